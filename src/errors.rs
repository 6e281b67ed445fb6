//! Typed errors as `thiserror` writes them, without what it takes to compile it: rooms of the slim build say theirs so.

/// An enum whose variants say what they mean: `#[error("…")]` before each, with its fields by name (`{0}` where it has one
/// without a name), and whatever `format!` takes besides; or `#[error(transparent)]`, which passes on what its field says.
/// `#[from]` makes the variant out of its field. What lies below is said with the error, not chained as its source.
macro_rules! errors {
    (
        $(#[$attribute:meta])*
        $visible:vis enum $name:ident {
            $(
                $(#[doc = $doc:literal])*
                #[error($($say:tt)*)]
                $variant:ident
                $({ $( $(#[$of_field:meta])* $field:ident: $type:ty ),* $(,)? })?
                $(( $(#[$from:ident])? $inner:ty ))?
            ),* $(,)?
        }
    ) => {
        $(#[$attribute])*
        $visible enum $name {
            $(
                $(#[doc = $doc])*
                $variant $({ $( $(#[$of_field])* $field: $type ),* })? $(( $inner ))?
            ),*
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                // Not every field is said.
                #[allow(unused_variables)]
                match self {
                    $(
                        Self::$variant $({ $($field),* })? $(( $crate::errors::errors!(@only inner $inner) ))? => {
                            $crate::errors::errors!(@say f ($($say)*) $((inner $inner))?)
                        }
                    )*
                }
            }
        }

        impl std::error::Error for $name {}

        $($( $($crate::errors::errors!(@from $from $name $variant $inner);)? )?)*
    };
    (@only $inner:ident $type:ty) => { $inner };
    (@say $f:ident (transparent) ($inner:ident $type:ty)) => { std::fmt::Display::fmt($inner, $f) };
    (@say $f:ident ($words:literal) ($inner:ident $type:ty)) => { write!($f, $words, $inner) };
    (@say $f:ident ($($say:tt)*)) => { write!($f, $($say)*) };
    (@from from $name:ident $variant:ident $inner:ty) => {
        impl From<$inner> for $name {
            fn from(inner: $inner) -> $name {
                $name::$variant(inner)
            }
        }
    };
}

pub(crate) use errors;

#[cfg(test)]
mod tests {
    errors! {
        /// Of every kind.
        #[derive(Debug, PartialEq)]
        enum Fault {
            /// Without a field.
            #[error("nothing was said")]
            Nothing,
            #[error("{said:.1} is too large{others}; at most {}", 2 * limit,
                others = if *more > 0 { format!(" (as are {more} more)") } else { String::new() })]
            Large {
                /// Metres.
                said: f64,
                limit: u32,
                more: usize,
            },
            #[error("no number: {0}")]
            Number(#[from] std::num::ParseIntError),
            #[error(transparent)]
            Text(std::fmt::Error),
        }
    }

    #[test]
    fn each_says_what_it_means() {
        let number = "x".parse::<u8>().unwrap_err();
        for (fault, words) in [
            (Fault::Nothing, "nothing was said".to_owned()),
            (Fault::Large { said: 7.25, limit: 3, more: 0 }, "7.2 is too large; at most 6".to_owned()),
            (
                Fault::Large { said: 7.25, limit: 3, more: 2 },
                "7.2 is too large (as are 2 more); at most 6".to_owned(),
            ),
            (Fault::from(number.clone()), format!("no number: {number}")),
            (Fault::Text(std::fmt::Error), std::fmt::Error.to_string()),
        ] {
            assert_eq!(fault.to_string(), words);
        }
    }
}
