//! Axes: the choices that make a permutation, and what each value asks of the linker.

use std::{collections::BTreeMap, sync::Arc};

use serde::Deserialize;
use umbrage_hints::did_you_mean;

use crate::{Cause, Error, Fault, Key, Pass, bits::Bits, file::SourceText, ron_text};

/// The axes of a library.
#[derive(Clone, Debug, Default)]
pub struct Axes {
    axes: BTreeMap<Arc<str>, Axis>,
    /// Capabilities by name, each with what it is.
    capabilities: BTreeMap<String, String>,
}

/// One choice.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// Description of the choice.
    pub doc: String,
    /// The value where a key says nothing; none where it must say.
    pub default: Option<String>,
    pub(crate) values: BTreeMap<Arc<str>, Effect>,
    /// Capabilities of each value that does not say what it provides.
    provides: Option<Vec<String>>,
    /// The values that do not say it.
    silent: Vec<Arc<str>>,
}

impl Axis {
    /// Its values, sorted.
    pub fn values(&self) -> impl Iterator<Item = &str> {
        self.values.keys().map(|value| &**value)
    }

    /// How the pass that `value` chooses is run; none where it does not tell.
    pub fn pass(&self, value: &str) -> Option<Pass> {
        self.values.get(value)?.pass
    }
}

/// Demands of a value on the linker. Modules are named by their package and path.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Effect {
    pub(crate) root: Option<String>,
    pub(crate) pass: Option<Pass>,
    /// The interface whose implementations the root calls in turn, one for each key of a shader of several.
    pub(crate) each: Option<String>,
    pub(crate) bind: BTreeMap<String, String>,
    pub(crate) features: Vec<String>,
    pub(crate) count_fetches: Option<CountFetches>,
    /// Capabilities that other choices may need.
    pub(crate) provides: Vec<String>,
    /// Capabilities of which each must be provided by some other choice.
    pub(crate) needs: Vec<String>,
    /// The same by numbers, for the library that has them.
    pub(crate) numbers: EffectNumbers,
}

/// A demand that a function be called before each texture fetch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CountFetches {
    /// The function, by its module's path and its name.
    pub(crate) call: String,
    /// The modules whose own fetches are none of the demand's.
    pub(crate) except: Vec<String>,
}

impl CountFetches {
    /// The modules that it names: the function's first.
    pub(crate) fn modules(&self) -> impl Iterator<Item = &str> {
        let (module, _) = self.call.rsplit_once("::").unwrap_or((&self.call, ""));
        std::iter::once(module).chain(self.except.iter().map(String::as_str))
    }
}

/// Demands of a value on the linker, by the numbers of a library's modules and features.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct EffectNumbers {
    pub(crate) root: Option<usize>,
    pub(crate) each: Option<usize>,
    pub(crate) bind: Vec<(usize, usize)>,
    pub(crate) features: Bits,
    pub(crate) counting: Option<Counting>,
    /// Capabilities, by their numbers among the library's.
    pub(crate) provided: Bits,
    pub(crate) needed: Bits,
}

/// A demand that a function be called before each texture fetch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Counting {
    /// The function's module.
    pub(crate) module: usize,
    /// The function's name.
    pub(crate) function: String,
    /// The modules whose own fetches are none of the demand's.
    pub(crate) except: Vec<usize>,
    /// The features under which the function is to be called.
    pub(crate) features: Vec<String>,
}

impl Axes {
    /// The axes, sorted by name.
    pub fn iter(&self) -> impl Iterator<Item = &Axis> {
        self.axes.values()
    }

    /// The axis `name`.
    pub fn get(&self, name: &str) -> Option<&Axis> {
        self.axes.get(name)
    }

    /// The value that `key` gives `axis`: its own, or the default.
    pub fn value<'a>(&'a self, key: &'a Key, axis: &str) -> Option<&'a str> {
        key.get(axis)
            .or_else(|| self.axes.get(axis)?.default.as_deref())
    }

    /// How the pass that `key` chooses is run; none where its value does not tell.
    pub fn pass(&self, key: &Key) -> Option<Pass> {
        self.effects(key).find_map(|(_, effect)| effect.pass)
    }

    /// Every flag that some value sets.
    pub(crate) fn features(&self) -> impl Iterator<Item = &str> {
        let effects = self.iter().flat_map(|axis| axis.values.values());
        effects.flat_map(|effect| effect.features.iter().map(String::as_str))
    }

    /// Effects of every value of every axis.
    pub(crate) fn effects_mut(&mut self) -> impl Iterator<Item = &mut Effect> {
        self.axes
            .values_mut()
            .flat_map(|axis| axis.values.values_mut())
    }

    /// Effects of `key` on the linker, axis by axis.
    pub(crate) fn effects<'a>(
        &'a self,
        key: &'a Key,
    ) -> impl Iterator<Item = (&'a Axis, &'a Effect)> {
        self.iter().filter_map(move |axis| {
            let value = self.value(key, &axis.name)?;
            Some((axis, axis.values.get(value)?))
        })
    }

    pub(crate) fn check_axis(&self, name: &str) -> Result<&Axis, Fault> {
        self.axes.get(name).ok_or_else(|| {
            let fault = Fault::new(Cause::Key, format!("no axis `{name}`"));
            let known: Vec<_> = self.axes.keys().map(|axis| &**axis).collect();
            suggest(fault, name, "axes", &known)
        })
    }

    pub(crate) fn check_value<'a>(
        &self,
        axis: &'a Axis,
        value: &str,
    ) -> Result<&'a Arc<str>, Fault> {
        match axis.values.get_key_value(value) {
            Some((known, _)) => Ok(known),
            None => {
                let message = format!("axis `{}` has no value `{value}`", axis.name);
                let known: Vec<_> = axis.values().collect();
                Err(suggest(
                    Fault::new(Cause::Key, message),
                    value,
                    "values",
                    &known,
                ))
            }
        }
    }

    /// The key of `choices`, which have all that they need.
    pub(crate) fn key<'a>(
        &self,
        choices: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Key, Fault> {
        let mut chosen: BTreeMap<&str, &Arc<str>> = BTreeMap::new();
        for (name, value) in choices {
            let axis = self.check_axis(name)?;
            let value = self.check_value(axis, value)?;
            if let Some(other) = chosen.insert(&axis.name, value)
                && other != value
            {
                let message = format!("axis `{name}` is both `{other}` and `{value}`");
                return Err(Fault::new(Cause::Key, message).note("give each axis one value"));
            }
        }
        self.check_complete(|axis| chosen.contains_key(axis))?;
        // Take the names and values from the axes, whose texts all keys share.
        let choices = self.axes.iter().filter_map(|(name, axis)| {
            let value = *chosen.get(&**name)?;
            (axis.default.as_deref() != Some(&**value)).then(|| (name.clone(), value.clone()))
        });
        let key = Key::new(choices);
        self.check_needs(&key)?;
        Ok(key)
    }

    /// Checks that what each of `key`'s choices needs is provided by another.
    fn check_needs(&self, key: &Key) -> Result<(), Fault> {
        let provided = |need: &String| {
            let mut effects = self.effects(key);
            effects.any(|(_, effect)| effect.provides.contains(need))
        };
        for (axis, effect) in self.effects(key) {
            if let Some(need) = effect.needs.iter().find(|need| !provided(need)) {
                let axis = &axis.name;
                let value = self.value(key, axis).unwrap_or("");
                let what = self.capabilities.get(need).map_or("", String::as_str);
                let message = format!(
                    "the combination {key} is excluded: {axis}={value} needs `{need}`, {what}"
                );
                let others = self.providers(need).collect::<Vec<_>>().join(" or ");
                return Err(Fault::new(Cause::Key, message)
                    .note(format!("choose {others}, or another value for `{axis}`")));
            }
        }
        Ok(())
    }

    /// Values that provide `capability`, as `axis=value`.
    pub(crate) fn providers(&self, capability: &str) -> impl Iterator<Item = String> {
        self.with_effect(move |effect| effect.provides.iter().any(|known| known == capability))
    }

    /// Values whose effect is of a kind, as `axis=value`.
    fn with_effect(&self, is: impl Fn(&Effect) -> bool) -> impl Iterator<Item = String> {
        self.iter().flat_map(move |axis| {
            let values = axis.values.iter().filter(|(_, effect)| is(effect));
            let named = values.map(|(value, _)| format!("{}={value}", axis.name));
            named.collect::<Vec<_>>()
        })
    }

    /// Names of the capabilities.
    pub(crate) fn capabilities(&self) -> impl Iterator<Item = &str> {
        self.capabilities.keys().map(String::as_str)
    }

    /// Checks that each axis that has no default is `given`.
    pub(crate) fn check_complete(&self, given: impl Fn(&str) -> bool) -> Result<(), Fault> {
        let missing = |axis: &&Axis| axis.default.is_none() && !given(&axis.name);
        let Some(axis) = self.iter().find(missing) else {
            return Ok(());
        };
        let message = format!("axis `{}` has no default and was not given", axis.name);
        let values: Vec<_> = axis.values().collect();
        Err(Fault::new(Cause::Key, message).note(format!("choose one of {}", values.join(", "))))
    }

    /// Name of `axis`, in the text that all keys share.
    pub(crate) fn name(&self, axis: &str) -> Arc<str> {
        match self.axes.get_key_value(axis) {
            Some((name, _)) => name.clone(),
            None => axis.into(),
        }
    }

    /// Takes in the axes of a package, after those that `merged` have: new axes, and new values for known ones.
    pub(crate) fn merge(
        &mut self,
        package: &str,
        source: &SourceText,
        merged: &[&SourceText],
    ) -> Result<(), Error> {
        let file: AxesFile = ron_text::parse(source)?;
        for (name, what) in file.capabilities {
            if let Some(other) = self.capabilities.get(&name) {
                let message = format!("the capability `{name}` is declared already: {other}");
                return Err(Fault::new(Cause::Manifest, message)
                    .at(ron_text::literal(source, &["capabilities", &name]))
                    .note("declare it in one package; the others may use it all the same")
                    .into());
            }
            self.capabilities.insert(name, what);
        }
        for (name, axis) in file.axes {
            self.merge_axis(package, (source, merged), name, axis)?;
        }
        Ok(())
    }

    fn merge_axis(
        &mut self,
        package: &str,
        (source, merged): (&SourceText, &[&SourceText]),
        name: String,
        file: AxisFile,
    ) -> Result<(), Error> {
        let fault = |message: String, path: &[&str]| {
            Error::from(Fault::new(Cause::Manifest, message).at(ron_text::literal(source, path)))
        };
        let axis = self
            .axes
            .entry(name.as_str().into())
            .or_insert_with(|| Axis {
                name: name.clone(),
                doc: String::new(),
                default: None,
                values: BTreeMap::new(),
                provides: None,
                silent: Vec::new(),
            });
        if let Some(doc) = file.doc {
            axis.doc = doc;
        }
        for (value, effect) in file.values {
            if (effect.pass.is_some() || effect.each.is_some()) && effect.root.is_none() {
                let message = format!("`{value}` of `{name}` tells of a pass, and has no root");
                return Err(Fault::new(Cause::Manifest, message)
                    .at(ron_text::literal(source, &[&name, &value]))
                    .note("let the value that names the entry points' module, its `root`, tell how they are run")
                    .into());
            }
            let own = |module: String| match module.strip_prefix("package::") {
                Some(path) => format!("{package}::{path}"),
                None => module,
            };
            let effect = Effect {
                root: effect.root.map(own),
                pass: effect.pass,
                each: effect.each.map(own),
                bind: effect
                    .bind
                    .into_iter()
                    .map(|(k, v)| (own(k), own(v)))
                    .collect(),
                features: effect.features,
                count_fetches: effect.count_fetches.map(|count| CountFetches {
                    call: own(count.call),
                    except: count.except.into_iter().map(own).collect(),
                }),
                provides: match effect.provides {
                    Some(provides) => provides,
                    None => {
                        axis.silent.push(value.as_str().into());
                        Vec::new()
                    }
                },
                needs: effect.needs,
                numbers: EffectNumbers::default(),
            };
            if axis.values.insert(value.as_str().into(), effect).is_some() {
                return Err(two_values(&name, &value, source, merged).into());
            }
        }
        if let Some(provides) = file.provides {
            if axis
                .provides
                .as_ref()
                .is_some_and(|other| *other != provides)
            {
                let message = format!("another package says already what `{name}` provides");
                return Err(Fault::new(Cause::Manifest, message)
                    .at(ron_text::literal(source, &[&name, "provides"]))
                    .note("let the values that differ say for themselves what they provide")
                    .into());
            }
            axis.provides = Some(provides);
        }
        // Packages are merged in the order of their names: one that adds values may come first.
        for value in &axis.silent {
            if let (Some(effect), Some(provides)) = (axis.values.get_mut(value), &axis.provides) {
                effect.provides.clone_from(provides);
            }
        }
        if let Some(default) = file.default {
            match &axis.default {
                Some(other) if *other != default => {
                    let message =
                        format!("axis `{name}` has the default `{other}` already, not `{default}`");
                    return Err(fault(message, &[&name, &default]));
                }
                _ => axis.default = Some(default.clone()),
            }
            if !axis.values.contains_key(default.as_str()) {
                let message = format!("axis `{name}` has no value `{default}` to be its default");
                return Err(fault(message, &[&name, &default]));
            }
        }
        Ok(())
    }
}

/// Fault for a value that two packages have.
fn two_values(name: &str, value: &str, source: &SourceText, merged: &[&SourceText]) -> Fault {
    let has = |earlier: &&&SourceText| {
        let file = ron_text::parse::<AxesFile>(earlier);
        file.is_ok_and(|file| {
            let axis = file.axes.get(name);
            axis.is_some_and(|axis| axis.values.contains_key(value))
        })
    };
    let message = format!("two packages have a value `{value}` for the axis `{name}`");
    let path = [name, "values", value];
    let mut fault = Fault::new(Cause::Manifest, message).at(ron_text::literal(source, &path));
    for earlier in merged.iter().filter(has) {
        fault = fault.at(ron_text::literal(earlier, &path));
    }
    fault.note("rename one of them, and the part that goes by its name")
}

fn suggest(fault: Fault, name: &str, what: &str, known: &[&str]) -> Fault {
    let fault = match did_you_mean(name, known.iter().copied()) {
        Some(hint) => fault.note(hint),
        None => fault,
    };
    match known {
        [] => fault.note(format!("there are no {what}")),
        _ => fault.note(format!("{what}: {}", known.join(", "))),
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AxesFile {
    #[serde(deserialize_with = "ron_text::unique")]
    axes: BTreeMap<String, AxisFile>,
    #[serde(default, deserialize_with = "ron_text::unique")]
    capabilities: BTreeMap<String, String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AxisFile {
    #[serde(default)]
    doc: Option<String>,
    #[serde(default)]
    default: Option<String>,
    #[serde(default)]
    provides: Option<Vec<String>>,
    #[serde(deserialize_with = "ron_text::unique")]
    values: BTreeMap<String, EffectFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EffectFile {
    #[serde(default)]
    root: Option<String>,
    #[serde(default)]
    pass: Option<Pass>,
    #[serde(default)]
    each: Option<String>,
    #[serde(default, deserialize_with = "ron_text::unique")]
    bind: BTreeMap<String, String>,
    #[serde(default)]
    features: Vec<String>,
    #[serde(default)]
    count_fetches: Option<CountFetchesFile>,
    #[serde(default)]
    provides: Option<Vec<String>>,
    #[serde(default)]
    needs: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CountFetchesFile {
    call: String,
    #[serde(default)]
    except: Vec<String>,
}
