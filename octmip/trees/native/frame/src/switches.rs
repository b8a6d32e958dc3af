//! Switches of a solver: every prune, bound and short cut that it can do without, for tests that the optimum stays.

/// Define the switches of a solver, each on by default, and their names.
#[macro_export]
macro_rules! switches {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// Prunes, bounds and short cuts, each on unless a test turns it off. The proofs stand where they are used.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub struct Switches {
            $($(#[$doc])* pub $name: bool,)*
        }

        impl Default for Switches {
            fn default() -> Self {
                Self { $($name: true,)* }
            }
        }

        impl Switches {
            /// The names of the switches.
            pub const NAMES: &'static [&'static str] = &[$(stringify!($name),)*];

            /// All switches on but those named; the first unknown name is the error.
            pub fn without<S: AsRef<str>>(off: &[S]) -> Result<Self, String> {
                let mut switches = Self::default();
                for name in off {
                    match name.as_ref() {
                        $(stringify!($name) => switches.$name = false,)*
                        unknown => return Err(unknown.to_string()),
                    }
                }
                Ok(switches)
            }
        }
    };
}

#[cfg(test)]
mod tests {
    switches! {
        /// One.
        one,
        /// Two.
        two,
    }

    #[test]
    fn switches_are_turned_off_by_name_and_unknown_names_refused() {
        assert_eq!(Switches::NAMES, ["one", "two"]);
        assert_eq!(Switches::without::<&str>(&[]), Ok(Switches::default()));
        assert_eq!(Switches::without(&["two"]), Ok(Switches { one: true, two: false }));
        assert_eq!(Switches::without(&["one", "three"]), Err("three".to_string()));
    }
}
