//! Holding a variant's figures against the limits.

use serde::Serialize;

use super::{
    figure::{Excepted, Figure, Values, is_optional},
    limits::{Limit, Limits},
};
use crate::figures::Figures;

/// How a variant did in a case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// Whether all limits are met, but for those that the variant is excepted from.
    pub passed: bool,
    /// Exceptions that it needs, with the reasons; none where it meets all.
    pub exception: Option<String>,
    /// The limits that it misses, by the figures' names.
    pub missed: Vec<Miss>,
    /// Figures that it is excepted from without need, as it meets the limit for all: the table must not
    /// list them.
    pub unnecessary: Vec<String>,
    /// Figures that meet the variant's own limit in all cases, and not the one for all variants.
    pub spared: Vec<String>,
}

/// A limit that is missed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Miss {
    /// The figure's name.
    pub figure: String,
    /// Figure found; none where the figure is missing or no number.
    pub found: Option<f64>,
    /// The limit.
    pub limit: Limit,
    /// Why the variant need not meet it; none where it must.
    pub excepted: Option<String>,
}

impl Limits {
    /// Holds `figures` of the variant called `variant` against the limits of `case`; `differs` is the figure [`DIFFERS`](super::DIFFERS) where
    /// the case has a twin. None where there is no such case.
    ///
    /// Every limit of the case's own must find its figure. One for every case is passed over where the
    /// picture has no such figure, such as an edge's displacement where there is no edge.
    pub fn judge(
        &self,
        case: &str,
        variant: &str,
        figures: &Figures,
        differs: Option<f64>,
    ) -> Option<Verdict> {
        let limits = self.case(case)?;
        let values = Values::new(figures, differs);
        let exceptions = self.entry(&limits.exceptions, variant);
        let mut missed = Vec::new();
        let mut unnecessary = Vec::new();
        let mut spared = Vec::new();

        for (figure, general) in self.general(limits) {
            let Figure(name) = figure;
            let found = values.get(name);
            let may_lack = !limits.any.contains_key(&figure) && is_optional(name);
            let meets = |limit: &Limit| found.map_or(may_lack, |found| limit.holds(found));
            let own = self.looser(variant, figure, &general);
            if own.is_some_and(&meets) && !meets(&general) {
                spared.push(name.to_owned());
            }
            let limit = own.cloned().unwrap_or(general);
            let holds = meets(&limit);
            let reason = exceptions.and_then(|e| e.0.get(&Excepted(figure)));
            match (holds, reason) {
                (true, None) => {}
                (true, Some(_)) => unnecessary.push(name.to_owned()),
                (false, _) => missed.push(Miss {
                    figure: name.to_owned(),
                    found,
                    limit,
                    excepted: reason.map(|reason| reason.0.clone()),
                }),
            }
        }
        let own = self.entry(&limits.methods, variant);
        for (Figure(name), limit) in own.into_iter().flat_map(|own| &own.0) {
            let found = values.get(name);
            if !found.is_some_and(|found| limit.holds(found)) {
                missed.push(Miss {
                    figure: (*name).to_owned(),
                    found,
                    limit: limit.clone(),
                    excepted: None,
                });
            }
        }
        let reason = |miss: &Miss| {
            let reason = miss.excepted.as_ref()?;
            Some(format!("{}: {reason}", miss.figure))
        };
        let reasons: Vec<_> = missed.iter().filter_map(reason).collect();
        Some(Verdict {
            passed: missed.iter().all(|miss| miss.excepted.is_some()),
            exception: (!reasons.is_empty()).then(|| reasons.join("; ")),
            missed,
            unnecessary,
            spared,
        })
    }
}
