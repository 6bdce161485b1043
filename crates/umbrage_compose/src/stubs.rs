//! Stand-ins for what a module takes from others, so that naga can parse the module by itself: a
//! function's signature with a zero result, copies of types, constants and resources.

use std::{
    collections::{BTreeMap, HashMap, VecDeque},
    fmt::Write as _,
};

use wgsl_parse::{
    span::Spanned,
    syntax::{
        Attribute, AttributeNode, Declaration, Expression, ExpressionNode, GlobalDeclaration,
        Ident, TemplateArg, TypeExpression,
    },
};

use crate::{
    Fault, Library,
    names::{self, Item, Meaning, Translations, declared},
};

/// Joins the parts of a path into one name, in as many bytes as `::`. It may stand in a WGSL
/// identifier, and no one writes it.
pub(crate) const JOINT: &str = "·";

/// The stand-ins in a module.
#[derive(Debug, Default)]
pub(crate) struct Stubs {
    /// WGSL to append to the module's own.
    pub(crate) text: String,
    /// Item that each name stands for.
    pub(crate) items: HashMap<String, Item>,
}

/// Builds the stand-ins for `module`, which calls each item by each of `wanted`'s names.
pub(crate) fn build(
    library: &Library,
    module: usize,
    wanted: &BTreeMap<String, Item>,
    translations: &mut dyn Translations,
) -> Result<Stubs, Fault> {
    let mut builder = Builder {
        library,
        module,
        translations,
        names: HashMap::new(),
        queue: VecDeque::new(),
        scopes: HashMap::new(),
        out: Stubs::default(),
    };
    // The module's own words for things come first, so that no other is made up for them.
    for (name, item) in wanted {
        builder.out.items.insert(name.clone(), item.clone());
        builder
            .names
            .entry(item.clone())
            .or_insert_with(|| name.clone());
        builder.queue.push_back((name.clone(), item.clone()));
    }
    while let Some((name, item)) = builder.queue.pop_front() {
        builder.stub(&name, &item)?;
    }
    Ok(builder.out)
}

struct Builder<'a> {
    library: &'a Library,
    module: usize,
    translations: &'a mut dyn Translations,
    /// Names that the module calls items by.
    names: HashMap<Item, String>,
    queue: VecDeque<(String, Item)>,
    scopes: HashMap<usize, BTreeMap<String, Meaning>>,
    out: Stubs,
}

impl Builder<'_> {
    fn stub(&mut self, name: &str, item: &Item) -> Result<(), Fault> {
        let main_name = self.names.get(item).cloned().unwrap_or_default();
        let translated = self.translations.translated(item.module)?;
        let declaration = translated
            .declarations
            .iter()
            .find(|declaration| declared(declaration).as_ref() == Some(&item.name));
        let Some(declaration) = declaration else {
            return Ok(());
        };
        // A second name for a type is an alias: a copy would be another type.
        let is_type = matches!(
            declaration.node(),
            GlobalDeclaration::Struct(_) | GlobalDeclaration::TypeAlias(_)
        );
        let own = item.module == self.module;
        if is_type && (own || main_name != name) {
            let target = if own { &item.name } else { &main_name };
            return self.write(format_args!("alias {name} = {target};"));
        }
        let mut declaration = declaration.node().clone();
        match &mut declaration {
            GlobalDeclaration::Struct(declaration) => {
                declaration.attributes.clear();
                declaration.ident = Ident::new(name.to_owned());
                for member in &mut declaration.members {
                    self.rename_attributes(item.module, &mut member.attributes)?;
                    self.rename_type(item.module, &mut member.ty)?;
                }
                self.write(format_args!("{declaration}"))
            }
            GlobalDeclaration::TypeAlias(declaration) => {
                declaration.attributes.clear();
                declaration.ident = Ident::new(name.to_owned());
                self.rename_type(item.module, &mut declaration.ty)?;
                self.write(format_args!("{declaration}"))
            }
            GlobalDeclaration::Function(function) => {
                let mut parameters = Vec::new();
                for parameter in &mut function.parameters {
                    self.rename_type(item.module, &mut parameter.ty)?;
                    parameters.push(format!("{}: {}", parameter.ident.name(), parameter.ty));
                }
                let parameters = parameters.join(", ");
                match &mut function.return_type {
                    Some(ty) => {
                        self.rename_type(item.module, ty)?;
                        self.write(format_args!(
                            "fn {name}({parameters}) -> {ty} {{ return {ty}(); }}"
                        ))
                    }
                    None => self.write(format_args!("fn {name}({parameters}) {{}}")),
                }
            }
            GlobalDeclaration::Declaration(declaration) => {
                self.variable(name, item.module, declaration)
            }
            GlobalDeclaration::Void | GlobalDeclaration::ConstAssert(_) => Ok(()),
        }
    }

    fn variable(&mut self, name: &str, module: usize, item: &mut Declaration) -> Result<(), Fault> {
        item.ident = Ident::new(name.to_owned());
        if let Some(ty) = &mut item.ty {
            self.rename_type(module, ty)?;
        }
        // The linker replaces this with the real declaration, so attributes are not needed, nor an initializer
        // where there is a type. A constant keeps its initializer: types and other constants may depend on its
        // value.
        item.attributes.clear();
        if item.kind.is_const() || item.ty.is_none() {
            if let Some(initializer) = &mut item.initializer {
                self.rename_expression(module, initializer)?;
            }
        } else {
            item.initializer = None;
        }
        self.write(format_args!("{item}"))
    }

    fn write(&mut self, text: std::fmt::Arguments<'_>) -> Result<(), Fault> {
        let start = self.out.text.len();
        // Writing to a string does not fail.
        let _ = writeln!(self.out.text, "{text}");
        // One line each, so that the text is short.
        let line = self.out.text.split_off(start).replace('\n', " ");
        self.out.text.push_str(line.trim_end());
        self.out.text.push('\n');
        Ok(())
    }

    fn rename_type(&mut self, module: usize, ty: &mut TypeExpression) -> Result<(), Fault> {
        if let Some(item) = self.meaning(module, ty)? {
            ty.path = None;
            ty.ident = Ident::new(self.name(item));
        }
        for TemplateArg { expression } in ty.template_args.iter_mut().flatten() {
            self.rename_expression(module, expression)?;
        }
        Ok(())
    }

    /// Renames names in the arguments of attributes: alignments, sizes, locations and the like are expressions.
    fn rename_attributes(
        &mut self,
        module: usize,
        attributes: &mut [AttributeNode],
    ) -> Result<(), Fault> {
        for attribute in attributes {
            match attribute.node_mut() {
                Attribute::Align(expression)
                | Attribute::BlendSrc(expression)
                | Attribute::Location(expression)
                | Attribute::Size(expression) => self.rename_expression(module, expression)?,
                // No other attribute of a member can refer to constants.
                _ => {}
            }
        }
        Ok(())
    }

    fn rename_expression(&mut self, module: usize, node: &mut ExpressionNode) -> Result<(), Fault> {
        let children: Vec<&mut Spanned<Expression>> = match node.node_mut() {
            Expression::Literal(_) => Vec::new(),
            Expression::Parenthesized(inner) => vec![&mut inner.expression],
            Expression::NamedComponent(inner) => vec![&mut inner.base],
            Expression::Indexing(inner) => vec![&mut inner.base, &mut inner.index],
            Expression::Unary(inner) => vec![&mut inner.operand],
            Expression::Binary(inner) => vec![&mut inner.left, &mut inner.right],
            Expression::FunctionCall(call) => {
                self.rename_type(module, &mut call.ty)?;
                call.arguments.iter_mut().collect()
            }
            Expression::TypeOrIdentifier(ty) => return self.rename_type(module, ty),
        };
        for child in children {
            self.rename_expression(module, child)?;
        }
        Ok(())
    }

    /// The declaration that `ty`'s name means in `module`; none for WGSL's own.
    fn meaning(&mut self, module: usize, ty: &TypeExpression) -> Result<Option<Item>, Fault> {
        let name = ty.ident.name().clone();
        let translated = self.translations.translated(module)?;
        if ty.path.is_none()
            && translated
                .declarations
                .iter()
                .any(|d| declared(d).as_ref() == Some(&name))
        {
            return Ok(Some(Item { module, name }));
        }
        if !self.scopes.contains_key(&module) {
            let scope = names::imports(self.library, module, &translated, self.translations)?;
            self.scopes.insert(module, scope);
        }
        let scope = &self.scopes[&module];
        match &ty.path {
            None => match scope.get(&name) {
                Some(Meaning::Item(item)) => Ok(Some(item.clone())),
                Some(Meaning::Nothing(fault)) => Err(fault.clone()),
                Some(Meaning::Module(_)) | None => Ok(None),
            },
            Some(path) => {
                let written = format!("{path}");
                let mut segments: Vec<_> = written.split("::").filter(|s| !s.is_empty()).collect();
                segments.push(&name);
                let source = self.library.source(module);
                let at = (source, 0..source.text.len());
                names::written_path(self.library, at, scope, &segments, self.translations).map(Some)
            }
        }
    }

    /// The module's name of `item`; queues a stand-in where it has no name for it yet.
    fn name(&mut self, item: Item) -> String {
        if let Some(name) = self.names.get(&item) {
            return name.clone();
        }
        if item.module == self.module {
            return item.name;
        }
        let path = self.library.source(item.module).path.replace("::", JOINT);
        let name = format!("{path}{JOINT}{}", item.name);
        self.names.insert(item.clone(), name.clone());
        self.out.items.insert(name.clone(), item.clone());
        self.queue.push_back((name.clone(), item));
        name
    }
}
