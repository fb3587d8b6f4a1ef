//! Blocks, the state that each ends with, and objects, which are blocks with a name.

use super::{Block, World, is_regular, string};
use crate::Result;
use crate::error::SourceLocation;
use crate::format::pbrt::tokens::Tokens;
use crate::scene::description::InstanceDescription;

impl World {
    pub(super) fn begin(&mut self, block: Block, at: SourceLocation) {
        self.stack.push((block, self.state.clone(), at));
    }

    pub(super) fn end(&mut self, block: Block, at: &SourceLocation) -> Result<()> {
        let Some((open, state, begun)) = self.stack.pop() else {
            return Err(at.error("nothing begins what ends here"));
        };
        if open != block {
            return Err(at.error(format!("what ends here is not what begins in line {}", begun.line)));
        }
        if block == Block::Transform && self.old {
            self.state.transform = state.transform;
        } else {
            self.state = state;
        }
        if block == Block::Object {
            self.object = None;
        }
        Ok(())
    }

    pub(super) fn object_begin(&mut self, tokens: &mut Tokens, at: SourceLocation) -> Result<()> {
        let name = string(tokens, "a name")?;
        if self.object.is_some() {
            return Err(at.error("an object within another is not read"));
        }
        if self.objects.insert(name.clone(), false).is_some() {
            return Err(at.error(format!("there are two objects \"{name}\"")));
        }
        self.begin(Block::Object, at);
        self.object = Some(name);
        Ok(())
    }

    pub(super) fn instance(&mut self, tokens: &mut Tokens, at: SourceLocation) -> Result<()> {
        let group = string(tokens, "the name of an object")?;
        if self.object.is_some() {
            return Err(at.error("an instance within an object is not read"));
        }
        let Some(seen) = self.objects.get(&group) else {
            return Err(at.error(format!("there is no object \"{group}\"")));
        };
        let transform = self.state.transform;
        if !is_regular(&transform.matrix3) {
            self.warnings.add(&at, format!("the transform flattens \"{group}\", which is not seen"));
        } else if *seen {
            self.instances.push(InstanceDescription { group, transform, location: Some(at) });
        }
        Ok(())
    }
}
