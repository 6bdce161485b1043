//! Where names stand beside their points, so that none covers another.

/// A point with a name.
pub(super) struct Mark {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) on_front: bool,
    /// Whether its name stands in any case, though it had to cover a point.
    pub(super) must: bool,
    pub(super) text: String,
}

/// A name that has found a place.
pub(super) struct Label<'a> {
    pub(super) mark: &'a Mark,
    /// Its left end.
    pub(super) x: f64,
    /// Its baseline.
    pub(super) y: f64,
    /// Where a line from the point ends; none where the name stands close by.
    pub(super) leader: Option<(f64, f64)>,
    pub(super) text: String,
}

/// A label's letters are about this wide: the page chooses the font, so this is on the safe side.
const LETTER: f64 = 6.7;
/// A letter of a script with wide ones.
const WIDE: f64 = 12.0;
const HEIGHT: f64 = 14.0;
/// Longer names are cut; the tooltip has them whole.
const MOST_LETTERS: usize = 30;
/// Half a point's size, with some air.
const POINT: f64 = 8.0;
/// How far from its point a name on the front may stand; others only at the first.
const REACH: [f64; 5] = [9.0, 18.0, 30.0, 44.0, 60.0];
/// From here on a line leads from the name to its point.
const LEADER_FROM: f64 = 18.0;

#[derive(Clone, Copy)]
struct Rect {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Rect {
    fn meets(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    fn around(x: f64, y: f64, half: f64) -> Self {
        Self {
            left: x - half,
            top: y - half,
            right: x + half,
            bottom: y + half,
        }
    }
}

/// Places for the names of `marks`, the earlier ones first served. A name that finds none is left out, unless it must stand: then
/// it covers points, but no other name.
/// Names keep off the `front`, a line through these corners, where they can.
pub(super) fn place_labels<'a>(
    marks: &'a [Mark],
    front: &[(f64, f64)],
    size: (f64, f64),
) -> Vec<Label<'a>> {
    let points: Vec<Rect> = marks
        .iter()
        .map(|mark| Rect::around(mark.x, mark.y, POINT))
        .collect();
    let front: Vec<Rect> = front
        .windows(2)
        .filter_map(|ends| match ends {
            [(x0, y0), (x1, y1)] => Some(Rect {
                left: x0.min(*x1) - 1.0,
                top: y0.min(*y1) - 1.0,
                right: x0.max(*x1) + 1.0,
                bottom: y0.max(*y1) + 1.0,
            }),
            _ => None,
        })
        .collect();
    // Left of the axis and below it stand the ticks.
    let plot = Rect {
        left: 76.0,
        top: 4.0,
        right: size.0 - 4.0,
        bottom: size.1 - 60.0,
    };
    let mut taken: Vec<Rect> = Vec::new();
    let mut labels = Vec::new();
    for mark in marks {
        let text = shortened(&mark.text);
        let width = width(&text);
        let reach = if mark.on_front || mark.must {
            &REACH[..]
        } else {
            &REACH[..1]
        };
        let inside = |rect: &Rect| {
            rect.left >= plot.left
                && rect.right <= plot.right
                && rect.top >= plot.top
                && rect.bottom <= plot.bottom
                && !taken.iter().any(|other| rect.meets(other))
        };
        let places: Vec<(f64, Rect)> = reach
            .iter()
            .flat_map(|distance| around(mark, width, *distance).map(|rect| (*distance, rect)))
            .filter(|(_, rect)| inside(rect))
            .collect();
        let covers = |lines: &[Rect], rect: &Rect| lines.iter().any(|line| rect.meets(line));
        let mut free = places.iter().filter(|(_, rect)| !covers(&points, rect));
        let found = (free.clone().find(|(_, rect)| !covers(&front, rect)))
            .or(free.next())
            .or(places.first().filter(|_| mark.must));
        let Some(&(distance, rect)) = found else {
            continue;
        };
        taken.push(rect);
        labels.push(Label {
            mark,
            x: rect.left,
            y: rect.bottom - 3.5,
            leader: (distance >= LEADER_FROM).then(|| nearest(&rect, mark)),
            text,
        });
    }
    labels
}

/// Eight places at a distance; below and to the left of the front no point can lie, so those first.
fn around(mark: &Mark, width: f64, distance: f64) -> [Rect; 8] {
    let diagonal = distance * 0.75;
    let at = |left: f64, top: f64| Rect {
        left,
        top,
        right: left + width,
        bottom: top + HEIGHT,
    };
    let (x, y) = (mark.x, mark.y);
    let (left, right) = (x - distance - width, x + distance);
    let (above, below) = (y - distance - HEIGHT, y + distance);
    let beside = y - HEIGHT / 2.0;
    let centred = x - width / 2.0;
    [
        at(x - diagonal - width, y + diagonal),
        at(left, beside),
        at(centred, below),
        at(x + diagonal, y - diagonal - HEIGHT),
        at(right, beside),
        at(centred, above),
        at(x + diagonal, y + diagonal),
        at(x - diagonal - width, y - diagonal - HEIGHT),
    ]
}

fn nearest(rect: &Rect, mark: &Mark) -> (f64, f64) {
    (
        mark.x.clamp(rect.left, rect.right),
        mark.y.clamp(rect.top, rect.bottom),
    )
}

fn shortened(text: &str) -> String {
    if text.chars().count() <= MOST_LETTERS {
        return text.to_owned();
    }
    text.chars().take(MOST_LETTERS - 1).chain(['…']).collect()
}

fn width(text: &str) -> f64 {
    text.chars()
        .map(|letter| if letter.is_ascii() { LETTER } else { WIDE })
        .sum()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn rect(label: &Label<'_>) -> Rect {
        Rect {
            left: label.x,
            top: label.y + 3.5 - HEIGHT,
            right: label.x + width(&label.text),
            bottom: label.y + 3.5,
        }
    }

    proptest! {
        #[test]
        fn no_name_covers_another_or_a_point(
            marks in prop::collection::vec((80.0..590.0, 10.0..330.0, any::<bool>(), "[a-z]{0,40}"), 1..40)
        ) {
            let marks: Vec<Mark> = marks
                .into_iter()
                .map(|(x, y, on_front, text)| Mark { x, y, on_front, must: false, text })
                .collect();
            let labels = place_labels(&marks, &[], (600.0, 400.0));
            for (index, label) in labels.iter().enumerate() {
                let own = rect(label);
                prop_assert!(own.left >= 76.0 && own.right <= 600.0 && own.bottom <= 340.1);
                for other in &labels[..index] {
                    // Shrunk by the rounding of the sums.
                    let other = rect(other);
                    let inner = Rect { left: other.left + 1e-9, right: other.right - 1e-9,
                        top: other.top + 1e-9, bottom: other.bottom - 1e-9 };
                    prop_assert!(inner.right < inner.left || !own.meets(&inner));
                }
                for mark in &marks {
                    prop_assert!(!own.meets(&Rect::around(mark.x, mark.y, POINT - 1e-9)));
                }
            }
        }
    }

    #[test]
    fn a_point_alone_has_its_name_close_by() {
        let mark = [Mark {
            x: 300.0,
            y: 200.0,
            on_front: false,
            must: false,
            text: "1024 pcf3".to_owned(),
        }];
        let labels = place_labels(&mark, &[], (600.0, 400.0));
        assert_eq!(labels.len(), 1);
        assert!(labels[0].leader.is_none());
    }

    #[test]
    fn a_name_keeps_off_the_front() {
        let mark = [Mark {
            x: 300.0,
            y: 200.0,
            on_front: true,
            must: false,
            text: "1024 pcf3".to_owned(),
        }];
        // The step of a neighbour passes below and to the left, where the name would stand.
        let front = [(270.0, 100.0), (270.0, 214.0), (500.0, 214.0)];
        let crosses = |front: &[(f64, f64)]| {
            let labels = place_labels(&mark, front, (600.0, 400.0));
            let own = rect(&labels[0]);
            own.left < 270.0 && own.right > 270.0 || own.top < 214.0 && own.bottom > 214.0
        };
        assert!(crosses(&[]));
        assert!(!crosses(&front));
    }

    /// Points all around leave no place free.
    #[test]
    fn a_name_that_must_stand_stands_in_a_crowd() {
        let points = (0..40).flat_map(|x| (0..30).map(move |y| (x, y)));
        let mut marks: Vec<Mark> = points
            .map(|(x, y)| Mark {
                x: 80.0 + 13.0 * f64::from(x),
                y: 10.0 + 11.0 * f64::from(y),
                on_front: true,
                must: false,
                text: "crowd".to_owned(),
            })
            .collect();
        assert!(place_labels(&marks, &[], (600.0, 400.0)).is_empty());
        marks[600].must = true;
        let labels = place_labels(&marks, &[], (600.0, 400.0));
        assert_eq!(labels.len(), 1);
    }

    #[test]
    fn a_long_name_is_cut() {
        assert_eq!(shortened(&"ä".repeat(30)), "ä".repeat(30));
        assert_eq!(shortened(&"ä".repeat(31)), format!("{}…", "ä".repeat(29)));
    }
}
