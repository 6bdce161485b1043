//! The methods that a renderer knows.

use std::{collections::BTreeMap, sync::Arc};

use umbrage_hints::ending;

use crate::ShadowMethod;

/// Shadow methods by their names: where methods and the renderer meet, neither seeing the other.
#[derive(Clone, Default)]
pub struct Registry(BTreeMap<String, Arc<dyn ShadowMethod>>);

/// Why a registry refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RegistryError {
    /// Two methods have one name.
    #[error("a shadow method `{name}` is already registered")]
    Taken {
        /// The name.
        name: String,
    },
    /// No method has this name.
    #[error("no shadow method `{name}` (known: {known}){hint}")]
    Unknown {
        /// As asked for.
        name: String,
        /// All names.
        known: String,
        /// The end of the message: which name may be meant.
        hint: String,
    },
}

impl Registry {
    /// No methods.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds `method` under its own name.
    ///
    /// # Errors
    /// [`RegistryError::Taken`]; what was there stays.
    pub fn register(&mut self, method: impl ShadowMethod + 'static) -> Result<(), RegistryError> {
        let name = method.name().to_owned();
        if self.0.contains_key(&name) {
            return Err(RegistryError::Taken { name });
        }
        self.0.insert(name, Arc::new(method));
        Ok(())
    }

    /// The method `name`.
    ///
    /// # Errors
    /// [`RegistryError::Unknown`].
    pub fn get(&self, name: &str) -> Result<&Arc<dyn ShadowMethod>, RegistryError> {
        self.0.get(name).ok_or_else(|| RegistryError::Unknown {
            name: name.to_owned(),
            known: self.names().collect::<Vec<_>>().join(", "),
            hint: ending(name, self.names()),
        })
    }

    /// The methods' names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// The methods, sorted by name.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<dyn ShadowMethod>> {
        self.0.values()
    }
}

impl std::fmt::Debug for Registry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_set().entries(self.names()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Frame, Light, PlanError, Setting, ShadowPlan, Support};

    struct Named(&'static str);

    impl ShadowMethod for Named {
        fn name(&self) -> &str {
            self.0
        }
        fn settings(&self) -> &[Setting] {
            &[]
        }
        fn axes(&self) -> &[&str] {
            &[]
        }
        fn supports(&self, _: &Light) -> Support {
            Support::Yes
        }
        fn plan(&self, _: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
            Ok(ShadowPlan::default())
        }
    }

    #[test]
    fn names_are_unique_sorted_and_suggested() {
        let mut registry = Registry::new();
        assert_eq!(registry.register(Named("variance")), Ok(()));
        assert_eq!(registry.register(Named("basic")), Ok(()));
        assert_eq!(
            registry.register(Named("basic")).map_err(|e| e.to_string()),
            Err("a shadow method `basic` is already registered".into())
        );
        assert_eq!(
            registry.iter().map(|m| m.name()).collect::<Vec<_>>(),
            ["basic", "variance"]
        );
        assert_eq!(
            registry.get("basic").map(|m| m.name().to_owned()),
            Ok("basic".into())
        );
        assert_eq!(
            registry
                .get("basics")
                .map(|_| ())
                .map_err(|e| e.to_string()),
            Err("no shadow method `basics` (known: basic, variance); did you mean `basic`?".into())
        );
    }
}
