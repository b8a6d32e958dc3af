//! Sloped errors: a target above its prediction costs `up / over` for each unit between them, one below it
//! `down / over`.
//!
//! Both slopes are 1 in absolute errors, `q` and `1 - q` in those of the quantile of level q. Costs are counted in
//! units of `1 / over`, so that they are whole.

/// Most that an error is divided by.
const MOST_OVER: i64 = 1000;

/// What one unit of distance costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Slopes {
    /// Of a target above its prediction.
    pub up: i64,
    /// Of a target below its prediction.
    pub down: i64,
    /// What both are divided by.
    pub over: i64,
}

impl Slopes {
    /// Those of absolute errors.
    pub const ABSOLUTE: Self = Self { up: 1, down: 1, over: 1 };

    /// The larger of the two.
    pub(crate) fn steepest(self) -> i64 {
        self.up.max(self.down)
    }

    /// What targets that are rounded down to whole numbers may cost less by, with so much weight in all: see `grid`.
    pub(crate) fn lost(self, total: i128) -> i128 {
        let (up, down) = (i128::from(self.up), i128::from(self.down));
        -((-total * up * down).div_euclid(up + down))
    }

    /// The error of targets so far above their prediction and so far below it together.
    pub(crate) fn cost(self, below: i64, above: i64) -> i64 {
        self.down * below + self.up * above
    }

    /// Whether these are slopes of absolute errors or of quantiles.
    pub(crate) fn is_known(self) -> bool {
        let is_quantile = self.up > 0 && self.down > 0 && self.up + self.down == self.over && self.over <= MOST_OVER;
        self == Self::ABSOLUTE || is_quantile
    }

    /// The error by its name: in files and logs.
    pub fn named(slopes: Option<Self>) -> String {
        match slopes {
            None => "squared".into(),
            Some(Self::ABSOLUTE) => "absolute".into(),
            Some(Self { up, over, .. }) => format!("quantile:{up}/{over}"),
        }
    }

    /// The error of a name, None where there is none of it.
    pub fn of_name(name: &str) -> Option<Option<Self>> {
        if name == "squared" {
            return Some(None);
        }
        if name == "absolute" {
            return Some(Some(Self::ABSOLUTE));
        }
        let (up, over) = name.strip_prefix("quantile:")?.split_once('/')?;
        let (up, over) = (up.parse::<i64>().ok()?, over.parse::<i64>().ok()?);
        let slopes = Self { up, down: over.checked_sub(up)?, over };
        (slopes.is_known() && Self::named(Some(slopes)) == name).then_some(Some(slopes))
    }
}
