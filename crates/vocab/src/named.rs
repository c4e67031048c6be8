//! What has a key for programs and words for people: laws, causes, alarms.

use strum::VariantArray;

/// A closed list of names. A key stands in files, options and the API, the words on the page and in the
/// terminal; both are written here and nowhere else.
pub trait Named: Copy + Into<&'static str> + VariantArray + 'static {
    /// All of them, in the order in which they are listed.
    const ALL: &'static [Self] = Self::VARIANTS;

    /// The words.
    fn text(self) -> &'static str;

    /// The key: the variant's name in kebab case.
    fn key(self) -> &'static str {
        self.into()
    }
}
