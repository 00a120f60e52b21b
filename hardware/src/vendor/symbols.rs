//! The table of a library's functions.

/// Declares a struct of the library's functions and a method that looks them up by their symbols. A
/// file that uses this macro must allow `unsafe`.
macro_rules! symbols {
    ($table:ident { $($field:ident = $symbol:literal: fn($($argument:ty),*) $(-> $result:ty)?;)* }) => {
        /// The library's functions.
        pub(super) struct $table {
            $($field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl $table {
            fn find(library: &libloading::os::unix::Library) -> Result<Self, libloading::Error> {
                Ok(Self {
                    $(
                        // SAFETY: the type is the one that the API documents for this symbol;
                        // the library is never closed, so the address stays good.
                        $field: unsafe { *library.get($symbol)? },
                    )*
                })
            }
        }

        impl std::fmt::Debug for $table {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(stringify!($table))
            }
        }
    };
}

pub(crate) use symbols;
