//! Messages for a host's user, and the categories that the host has enabled.

/// Category of a message. A door maps it to the log categories and statuses of its standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// The events of the motion.
    Events,
    /// Warnings without a refusal.
    Warnings,
    /// A call carried out in part: a step that ended early, a value that is not available.
    Incomplete,
    /// Refused calls.
    Refusals,
    /// The instance can no longer be used.
    Failures,
}

/// All categories.
pub const CATEGORIES: [Category; 5] =
    [Category::Events, Category::Warnings, Category::Incomplete, Category::Refusals, Category::Failures];

/// Destination of a component's messages.
pub trait Log {
    /// Whether messages of this category are enabled. A caller need not compose messages of other
    /// categories.
    fn wants(&self, category: Category) -> bool;

    /// Takes one finished message without trailing line break.
    fn log(&mut self, category: Category, message: &str);
}

/// A log without any enabled category.
#[derive(Clone, Copy, Debug)]
pub struct Silence;

impl Log for Silence {
    fn wants(&self, _: Category) -> bool {
        false
    }

    fn log(&mut self, _: Category, _: &str) {}
}

/// A set of categories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Categories(u8);

impl Categories {
    /// Every category.
    pub const ALL: Self = Self((1 << CATEGORIES.len()) - 1);
    /// No category.
    pub const NONE: Self = Self(0);

    /// Whether a category is in the set.
    pub const fn contains(self, category: Category) -> bool {
        self.0 & (1 << category as u8) != 0
    }

    /// The set with a category added or removed.
    #[must_use]
    pub const fn with(self, category: Category, on: bool) -> Self {
        let bit = 1 << category as u8;
        Self(if on { self.0 | bit } else { self.0 & !bit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_each_category_is_in_the_set_once() {
        let all = CATEGORIES.iter().fold(Categories::NONE, |set, category| set.with(*category, true));
        assert_eq!(all, Categories::ALL);
        let events = Categories::NONE.with(Category::Events, true);
        assert!(events.contains(Category::Events) && !events.contains(Category::Refusals));
        assert_eq!(events.with(Category::Events, false), Categories::NONE);
    }
}
