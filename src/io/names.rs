//! Names that a file gives its facets, stored once per combination.

use rustc_hash::FxHashMap;

/// Names in force at one facet.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct NameSet {
    /// `g` names of an OBJ; a facet can be in several groups.
    pub groups: Vec<String>,
    /// `o` name of an OBJ, solid name of an ASCII STL.
    pub object: Option<String>,
    /// `usemtl` name of an OBJ.
    pub material: Option<String>,
}

impl NameSet {
    /// Groups, object and material in this order.
    pub fn all(&self) -> impl Iterator<Item = &str> {
        self.groups
            .iter()
            .chain(&self.object)
            .chain(&self.material)
            .map(String::as_str)
    }
}

/// The names of every facet: few sets, one small number a facet.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FacetNames {
    sets: Vec<NameSet>,
    set_of: Vec<u32>,
}

impl FacetNames {
    /// The combinations that occur.
    pub fn sets(&self) -> &[NameSet] {
        &self.sets
    }

    /// Place in [`FacetNames::sets`] for a facet.
    pub fn set_of(&self, facet: u32) -> u32 {
        self.set_of[facet as usize]
    }

    /// Names of a facet.
    pub fn of(&self, facet: u32) -> &NameSet {
        &self.sets[self.set_of(facet) as usize]
    }

    /// Number of facets.
    pub fn len(&self) -> usize {
        self.set_of.len()
    }

    /// Whether there are no facets.
    pub fn is_empty(&self) -> bool {
        self.set_of.is_empty()
    }

    /// Facets of a format without names.
    pub(crate) fn unnamed(facets: usize) -> FacetNames {
        FacetNames {
            sets: vec![NameSet::default()],
            set_of: vec![0; facets],
        }
    }
}

/// Collects names facet by facet, as the file states them.
#[derive(Default)]
pub(crate) struct NamesBuilder {
    names: FacetNames,
    number_of: FxHashMap<NameSet, u32>,
    current: NameSet,
    current_number: Option<u32>,
}

impl NamesBuilder {
    pub(crate) fn set_groups(&mut self, groups: Vec<String>) {
        self.current.groups = groups;
        self.current_number = None;
    }

    pub(crate) fn set_object(&mut self, object: Option<String>) {
        self.current.object = object;
        self.current_number = None;
    }

    pub(crate) fn set_material(&mut self, material: Option<String>) {
        self.current.material = material;
        self.current_number = None;
    }

    /// One more facet under the names in force.
    pub(crate) fn push_facet(&mut self) {
        let number = match self.current_number {
            Some(number) => number,
            None => {
                let next = self.names.sets.len() as u32;
                let number = match self.number_of.get(&self.current) {
                    Some(&number) => number,
                    None => {
                        self.names.sets.push(self.current.clone());
                        self.number_of.insert(self.current.clone(), next);
                        next
                    }
                };
                self.current_number = Some(number);
                number
            }
        };
        self.names.set_of.push(number);
    }

    pub(crate) fn finish(self) -> FacetNames {
        self.names
    }
}
