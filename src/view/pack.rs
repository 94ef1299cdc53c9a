//! Facts and arrays in one run of bytes, as the page reads them.
//!
//! ```text
//! u32 length of the header, little-endian
//! header: JSON { "facts": {..}, "arrays": { NAME: { "type", "start", "length" } } }, spaces to a multiple of 8
//! arrays: little-endian, each starts at `start` bytes behind the header, a multiple of 8
//! ```

use serde_json::{Map, Value, json};

/// Arrays start at multiples of this, as typed arrays of the page must.
const ALIGNMENT: usize = 8;

/// A pack in the making.
#[derive(Debug, Default)]
pub(super) struct Pack {
    facts: Map<String, Value>,
    arrays: Map<String, Value>,
    bytes: Vec<u8>,
}

impl Pack {
    pub(super) fn fact(&mut self, name: &str, value: impl Into<Value>) {
        self.facts.insert(name.to_owned(), value.into());
    }

    pub(super) fn f32(&mut self, name: &str, values: impl IntoIterator<Item = f32>) {
        let bytes = values.into_iter().flat_map(f32::to_le_bytes);
        self.array(name, "f32", 4, bytes);
    }

    pub(super) fn u32(&mut self, name: &str, values: impl IntoIterator<Item = u32>) {
        let bytes = values.into_iter().flat_map(u32::to_le_bytes);
        self.array(name, "u32", 4, bytes);
    }

    pub(super) fn u8(&mut self, name: &str, values: impl IntoIterator<Item = u8>) {
        self.array(name, "u8", 1, values.into_iter());
    }

    fn array(&mut self, name: &str, kind: &str, size: usize, bytes: impl Iterator<Item = u8>) {
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        let length = (self.bytes.len() - start) / size;
        let entry = json!({ "type": kind, "start": start, "length": length });
        self.arrays.insert(name.to_owned(), entry);
        let end = self.bytes.len().next_multiple_of(ALIGNMENT);
        self.bytes.resize(end, 0);
    }

    /// The bytes.
    pub(super) fn finish(self) -> Vec<u8> {
        let mut header = json!({ "facts": self.facts, "arrays": self.arrays })
            .to_string()
            .into_bytes();
        // The length itself takes four bytes.
        let end = (4 + header.len()).next_multiple_of(ALIGNMENT) - 4;
        header.resize(end, b' ');
        let mut all = (header.len() as u32).to_le_bytes().to_vec();
        all.extend(header);
        all.extend(self.bytes);
        all
    }
}

#[cfg(test)]
mod tests {
    use super::Pack;
    use serde_json::Value;

    #[test]
    fn arrays_stand_where_the_header_says() {
        let mut pack = Pack::default();
        pack.fact("name", "plate");
        pack.u8("marks", [1, 0, 1]);
        pack.u32("corners", [7, 8, 9]);
        pack.f32("lengths", [0.5]);
        let bytes = pack.finish();
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        assert_eq!((4 + length) % 8, 0);
        let header: Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
        assert_eq!(header["facts"]["name"], "plate");
        let body = &bytes[4 + length..];
        let start = |name: &str| header["arrays"][name]["start"].as_u64().unwrap() as usize;
        assert_eq!(body[start("marks")..][..3], [1, 0, 1]);
        assert_eq!(body[start("corners")..][..4], 7u32.to_le_bytes());
        assert_eq!(body[start("lengths")..][..4], 0.5f32.to_le_bytes());
        assert_eq!(start("corners") % 8 + start("lengths") % 8, 0);
        assert_eq!(header["arrays"]["corners"]["length"], 3);
    }
}
