//! Conditional translation: what of a module is there, under some features.
//!
//! Nothing is deleted: what is disabled is blanked out with spaces, so that every byte that stays
//! keeps its place and every span that naga gives is one in the author's file.

use std::{
    cell::RefCell,
    ops::Range,
    sync::{Arc, PoisonError, RwLock},
};

use wgsl_parse::{
    lexer::Token,
    span::Spanned,
    syntax::{
        Attribute, AttributeNode, BinaryOperator, CompoundStatement, ContinuingStatement,
        Expression, ExpressionNode, Function, GlobalDeclaration, GlobalDeclarationNode,
        GlobalDirective, ImportStatement, LiteralExpression, Statement, StatementNode, Struct,
        UnaryOperator,
    },
};

use crate::{
    Cause, Fault, Library,
    features::{Consulted, Features},
    source::{Source, Syntax},
};

/// A module as it is under some features.
#[derive(Debug, Default)]
pub(crate) struct Translated {
    /// Imports in the text, and their places.
    pub(crate) imports: Vec<(ImportStatement, Range<usize>)>,
    /// The declarations that are there, without the parts that are not. A function's body is left
    /// out: only the text has it.
    pub(crate) declarations: Vec<GlobalDeclarationNode>,
    /// Blanked parts: code that is not there, all imports, directives' conditions and translate-time attributes; sorted.
    pub(crate) blanks: Vec<Range<usize>>,
    /// The features that were looked up, with what was found.
    pub(crate) consulted: Consulted,
    /// The same, in the order of the first questions.
    pub(crate) asked: Vec<usize>,
}

/// Translations of a library's modules, each made once for all features that agree on what it consults.
#[derive(Debug)]
pub(crate) struct TranslatedModules(Vec<RwLock<Vec<Arc<Translated>>>>);

impl TranslatedModules {
    pub(crate) fn new(library: &Library) -> Self {
        Self(
            library
                .sources()
                .iter()
                .map(|_| RwLock::default())
                .collect(),
        )
    }

    /// The module of `library` under `features`, of which those that it consults count as asked for.
    pub(crate) fn get(
        &self,
        library: &Library,
        module: usize,
        features: &Features<'_>,
    ) -> Result<Arc<Translated>, Fault> {
        let agrees = |known: &&Arc<Translated>| {
            let mut found = features.enabled.clone();
            found.intersect(&known.consulted.asked);
            found == known.consulted.found
        };
        let all = self.0[module]
            .read()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = all.iter().find(agrees) {
            features.ask(&known.asked);
            return Ok(known.clone());
        }
        drop(all);
        let asked = RefCell::default();
        let own = Features {
            asked: &asked,
            ..*features
        };
        let made = translate(library.source(module), library.syntax(module)?, &own);
        let asked = asked.into_inner();
        features.ask(&asked);
        let made = Arc::new(Translated { asked, ..made? });
        let mut all = self.0[module]
            .write()
            .unwrap_or_else(PoisonError::into_inner);
        if !all.iter().any(|known| agrees(&known)) {
            all.push(made.clone());
        }
        Ok(made)
    }
}

/// Translates `source` under `features`.
fn translate(
    source: &Source,
    syntax: &Syntax,
    features: &Features<'_>,
) -> Result<Translated, Fault> {
    let mut translator = Translator {
        source,
        syntax,
        features,
        out: Translated::default(),
        chain: Chain::None,
    };
    translator.unit()?;
    let mut out = translator.out;
    out.blanks.sort_by_key(|range| (range.start, range.end));
    Ok(out)
}

struct Translator<'a> {
    source: &'a Source,
    syntax: &'a Syntax,
    features: &'a Features<'a>,
    out: Translated,
    chain: Chain,
}

/// Outcome of the `@if` and `@elif`s just before.
#[derive(Clone, Copy, PartialEq)]
enum Chain {
    /// There was none.
    None,
    /// None of them held.
    Open,
    /// One of them held.
    Taken,
}

impl Translator<'_> {
    fn unit(&mut self) -> Result<(), Fault> {
        let tree = &self.syntax.tree;
        self.chain = Chain::None;
        let mut statements = self
            .keyword_spans(|token| *token == Token::KwImport)
            .into_iter();
        for import in &tree.imports {
            let keyword = statements.next().unwrap_or(0..0);
            let range = self.to_semicolon(start_of(&import.attributes, keyword.start));
            if self.keep(&import.attributes)? {
                self.out.imports.push((import.clone(), range.clone()));
            }
            self.out.blanks.push(range);
        }
        self.chain = Chain::None;
        for directive in &tree.global_directives {
            let attributes = match directive {
                GlobalDirective::Diagnostic(directive) => &directive.attributes,
                GlobalDirective::Enable(directive) => &directive.attributes,
                GlobalDirective::Requires(directive) => &directive.attributes,
            };
            if !self.keep(attributes)? {
                let range = self.to_semicolon(start_of(attributes, 0));
                self.out.blanks.push(range);
            }
        }
        self.chain = Chain::None;
        for node in &tree.global_declarations {
            if self.keep(declaration_attributes(node))? {
                let declaration = self.declaration(node)?;
                self.out.declarations.push(declaration);
            } else {
                self.out.blanks.push(node.span().range());
            }
        }
        Ok(())
    }

    fn declaration(
        &mut self,
        node: &GlobalDeclarationNode,
    ) -> Result<GlobalDeclarationNode, Fault> {
        let declaration = match node.node() {
            GlobalDeclaration::Struct(item) => {
                let mut kept = Struct {
                    attributes: item.attributes.clone(),
                    ident: item.ident.clone(),
                    members: Vec::new(),
                };
                let outer = std::mem::replace(&mut self.chain, Chain::None);
                for member in &item.members {
                    if self.keep(&member.attributes)? {
                        let mut member = member.clone();
                        strip(&mut member.attributes);
                        kept.members.push(member);
                    } else {
                        let range = member.span().range();
                        let end = self.past_comma(range.end);
                        self.out.blanks.push(range.start..end);
                    }
                }
                self.chain = outer;
                GlobalDeclaration::Struct(kept)
            }
            GlobalDeclaration::Function(item) => {
                let mut kept = Function {
                    attributes: item.attributes.clone(),
                    ident: item.ident.clone(),
                    parameters: Vec::new(),
                    return_attributes: item.return_attributes.clone(),
                    return_type: item.return_type.clone(),
                    body: CompoundStatement::default(),
                };
                let outer = std::mem::replace(&mut self.chain, Chain::None);
                for parameter in &item.parameters {
                    if self.keep(&parameter.attributes)? {
                        let mut parameter = parameter.clone();
                        strip(&mut parameter.attributes);
                        kept.parameters.push(parameter);
                    } else {
                        let range = self.parameter(start_of(&parameter.attributes, 0));
                        self.out.blanks.push(range);
                    }
                }
                self.chain = outer;
                self.block(&item.body)?;
                GlobalDeclaration::Function(kept)
            }
            GlobalDeclaration::Declaration(item) => {
                let mut kept = item.clone();
                strip(&mut kept.attributes);
                GlobalDeclaration::Declaration(kept)
            }
            other => other.clone(),
        };
        Ok(Spanned::new(declaration, node.span()))
    }

    fn block(&mut self, block: &CompoundStatement) -> Result<(), Fault> {
        self.statements(&block.statements)
    }

    fn statements(&mut self, statements: &[StatementNode]) -> Result<(), Fault> {
        let outer = std::mem::replace(&mut self.chain, Chain::None);
        for statement in statements {
            if self.keep(statement_attributes(statement))? {
                self.statement(statement)?;
            } else {
                self.out.blanks.push(statement.span().range());
            }
        }
        self.chain = outer;
        Ok(())
    }

    fn statement(&mut self, statement: &Statement) -> Result<(), Fault> {
        match statement {
            Statement::Compound(block) => self.block(block),
            Statement::If(item) => {
                self.block(&item.if_clause.body)?;
                for clause in &item.else_if_clauses {
                    self.block(&clause.body)?;
                }
                match &item.else_clause {
                    Some(clause) => self.block(&clause.body),
                    None => Ok(()),
                }
            }
            Statement::Switch(item) => {
                let outer = std::mem::replace(&mut self.chain, Chain::None);
                for clause in &item.clauses {
                    self.clause(&clause.attributes, &clause.body)?;
                }
                self.chain = outer;
                Ok(())
            }
            Statement::Loop(item) => {
                self.block(&item.body)?;
                match &item.continuing {
                    Some(continuing) => self.continuing(continuing),
                    None => Ok(()),
                }
            }
            Statement::For(item) => self.block(&item.body),
            Statement::While(item) => self.block(&item.body),
            _ => Ok(()),
        }
    }

    fn continuing(&mut self, continuing: &ContinuingStatement) -> Result<(), Fault> {
        let outer = std::mem::replace(&mut self.chain, Chain::None);
        let kept = self.keep(&continuing.attributes)?;
        self.chain = outer;
        if !kept {
            let range = self.to_block_end(start_of(&continuing.attributes, 0));
            self.out.blanks.push(range);
            return Ok(());
        }
        self.block(&continuing.body)?;
        if let Some(break_if) = &continuing.break_if {
            let outer = std::mem::replace(&mut self.chain, Chain::None);
            if !self.keep(&break_if.attributes)? {
                let range = self.to_semicolon(start_of(&break_if.attributes, 0));
                self.out.blanks.push(range);
            }
            self.chain = outer;
        }
        Ok(())
    }

    /// A `case` or `default` with its block.
    fn clause(
        &mut self,
        attributes: &[AttributeNode],
        body: &CompoundStatement,
    ) -> Result<(), Fault> {
        if self.keep(attributes)? {
            self.block(body)
        } else {
            let range = self.to_block_end(start_of(attributes, 0));
            self.out.blanks.push(range);
            Ok(())
        }
    }

    /// Whether what has these attributes is there; blanks out the translate-time ones.
    fn keep(&mut self, attributes: &[AttributeNode]) -> Result<bool, Fault> {
        let mut condition: Option<&AttributeNode> = None;
        for attribute in attributes {
            if !is_condition(attribute) {
                continue;
            }
            if let Some(first) = condition {
                let message = "only one of `@if`, `@elif` and `@else` may stand here";
                return Err(Fault::new(Cause::Syntax, message)
                    .at(self.source.place(attribute.span().range()))
                    .at(self
                        .source
                        .place_labelled(first.span().range(), "the first"))
                    .note("join the conditions with `&&`"));
            }
            condition = Some(attribute);
            self.out.blanks.push(attribute.span().range());
        }
        let Some(attribute) = condition else {
            self.chain = Chain::None;
            return Ok(true);
        };
        let kept = match (attribute.node(), self.chain) {
            (Attribute::If(condition), _) => self.evaluate(condition)?,
            (_, Chain::None) => {
                let message = "`@elif` and `@else` must follow an `@if` or `@elif`";
                return Err(Fault::new(Cause::Syntax, message)
                    .at(self.source.place(attribute.span().range()))
                    .note(
                        "put it on the very next declaration, member, parameter, statement or case",
                    ));
            }
            (_, Chain::Taken) => false,
            (Attribute::Elif(condition), Chain::Open) => self.evaluate(condition)?,
            (_, Chain::Open) => true,
        };
        self.chain = match (attribute.node(), kept || self.chain_taken(attribute)) {
            (Attribute::Else, _) => Chain::None,
            (_, true) => Chain::Taken,
            (_, false) => Chain::Open,
        };
        Ok(kept)
    }

    /// Whether an earlier part of the chain that `attribute` goes on has held.
    fn chain_taken(&self, attribute: &AttributeNode) -> bool {
        !matches!(attribute.node(), Attribute::If(_)) && self.chain == Chain::Taken
    }

    fn evaluate(&mut self, condition: &ExpressionNode) -> Result<bool, Fault> {
        match condition.node() {
            Expression::Literal(LiteralExpression::Bool(value)) => Ok(*value),
            Expression::Parenthesized(inner) => self.evaluate(&inner.expression),
            Expression::Unary(unary) if unary.operator == UnaryOperator::LogicalNegation => {
                Ok(!self.evaluate(&unary.operand)?)
            }
            Expression::Binary(binary) if binary.operator == BinaryOperator::ShortCircuitAnd => {
                Ok(self.evaluate(&binary.left)? && self.evaluate(&binary.right)?)
            }
            Expression::Binary(binary) if binary.operator == BinaryOperator::ShortCircuitOr => {
                Ok(self.evaluate(&binary.left)? || self.evaluate(&binary.right)?)
            }
            Expression::TypeOrIdentifier(name)
                if name.path.is_none() && name.template_args.is_none() =>
            {
                let feature = name.ident.name();
                self.features
                    .get(&feature, &mut self.out.consulted)
                    .map_err(|fault| fault.at(self.source.place(condition.span().range())))
            }
            _ => Err(Fault::new(Cause::Syntax, "not a condition on features")
                .at(self.source.place(condition.span().range()))
                .note("use feature names, `true`, `false`, `!`, `&&`, `||` and parentheses")),
        }
    }

    fn keyword_spans(&self, keyword: impl Fn(&Token) -> bool) -> Vec<Range<usize>> {
        let tokens = self.syntax.tokens.iter();
        tokens
            .filter(|(token, _)| keyword(token))
            .map(|(_, range)| range.clone())
            .collect()
    }

    /// The tokens from `start` on.
    fn tokens_from(&self, start: usize) -> &[(Token, Range<usize>)] {
        let index = self
            .syntax
            .tokens
            .partition_point(|(_, range)| range.start < start);
        &self.syntax.tokens[index..]
    }

    fn to_semicolon(&self, start: usize) -> Range<usize> {
        let tokens = self.tokens_from(start);
        let end = tokens
            .iter()
            .find(|(token, _)| *token == Token::SymSemicolon);
        start..end.map_or(start, |(_, range)| range.end)
    }

    /// From `start` to the end of the first block.
    fn to_block_end(&self, start: usize) -> Range<usize> {
        let mut depth = 0usize;
        for (token, range) in self.tokens_from(start) {
            match token {
                Token::SymBraceLeft => depth += 1,
                Token::SymBraceRight if depth == 1 => return start..range.end,
                Token::SymBraceRight => depth = depth.saturating_sub(1),
                _ => {}
            }
        }
        start..start
    }

    /// The parameter that starts at `start`, with the comma after it.
    fn parameter(&self, start: usize) -> Range<usize> {
        let mut depth = 0usize;
        for (token, range) in self.tokens_from(start) {
            match token {
                Token::SymParenLeft | Token::SymBracketLeft | Token::TemplateArgsStart => {
                    depth += 1
                }
                Token::SymComma if depth == 0 => return start..range.end,
                Token::SymParenRight if depth == 0 => return start..range.start,
                Token::SymParenRight | Token::SymBracketRight | Token::TemplateArgsEnd => {
                    depth = depth.saturating_sub(1);
                }
                _ => {}
            }
        }
        start..start
    }

    /// The end of the comma that follows `end`, if one does.
    fn past_comma(&self, end: usize) -> usize {
        match self.tokens_from(end).first() {
            Some((Token::SymComma, range)) => range.end,
            _ => end,
        }
    }
}

/// Takes the translate-time attributes away.
fn strip(attributes: &mut Vec<AttributeNode>) {
    attributes.retain(|attribute| !is_condition(attribute));
}

fn is_condition(attribute: &Attribute) -> bool {
    matches!(
        attribute,
        Attribute::If(_) | Attribute::Elif(_) | Attribute::Else
    )
}

/// Where a node with these attributes starts, `bare` if it has none.
fn start_of(attributes: &[AttributeNode], bare: usize) -> usize {
    attributes
        .first()
        .map_or(bare, |attribute| attribute.span().start)
}

fn declaration_attributes(declaration: &GlobalDeclaration) -> &[AttributeNode] {
    match declaration {
        GlobalDeclaration::Void => &[],
        GlobalDeclaration::Declaration(item) => &item.attributes,
        GlobalDeclaration::TypeAlias(item) => &item.attributes,
        GlobalDeclaration::Struct(item) => &item.attributes,
        GlobalDeclaration::Function(item) => &item.attributes,
        GlobalDeclaration::ConstAssert(item) => &item.attributes,
    }
}

fn statement_attributes(statement: &Statement) -> &[AttributeNode] {
    match statement {
        Statement::Void => &[],
        Statement::Compound(item) => &item.attributes,
        Statement::Assignment(item) => &item.attributes,
        Statement::Increment(item) => &item.attributes,
        Statement::Decrement(item) => &item.attributes,
        Statement::If(item) => &item.attributes,
        Statement::Switch(item) => &item.attributes,
        Statement::Loop(item) => &item.attributes,
        Statement::For(item) => &item.attributes,
        Statement::While(item) => &item.attributes,
        Statement::Break(item) => &item.attributes,
        Statement::Continue(item) => &item.attributes,
        Statement::Return(item) => &item.attributes,
        Statement::Discard(item) => &item.attributes,
        Statement::FunctionCall(item) => &item.attributes,
        Statement::ConstAssert(item) => &item.attributes,
        Statement::Declaration(item) => &item.attributes,
    }
}
