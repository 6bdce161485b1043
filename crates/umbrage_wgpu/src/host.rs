//! The engine's side of a plan: its casters.

use std::{collections::HashMap, error::Error as StdError, sync::Arc};

use umbrage_compose::{BindingKind, Composed};
use umbrage_shadow::{Constants, Pass};

use crate::{Binder, DrawState, Error, Pipeline, Sides, execute::Shared, vertices_read};

/// Which caster it is, and in what state: a map is drawn again where either is another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Identity {
    /// The caster, the same from frame to frame.
    pub id: u64,
    /// Its state: another whenever its mesh, its transform or its material is.
    pub revision: u64,
}

impl Identity {
    /// As many casters as are asked for, none of which ever changes.
    pub fn unchanging(count: usize) -> Vec<Self> {
        let one = |id| Self { id, revision: 0 };
        (0..count as u64).map(one).collect()
    }
}

/// A set of timestamps, and which of them are those of a pass's beginning and end.
pub type Times = (wgpu::QuerySet, [u32; 2]);

/// Whether casters were drawn, and if not, why not, in the engine's own words.
pub type Drawn = Result<(), Box<dyn StdError + Send + Sync>>;

/// An engine, while a plan of its is executed.
pub trait Host {
    /// Draws casters into a pass: those at these places of the [frame](umbrage_shadow::Frame::casters)'s list, ascending.
    ///
    /// # Errors
    /// The engine's own; the light then has no shadow.
    fn draw(&mut self, casters: &[usize], draws: &mut Draws<'_, '_>) -> Drawn;

    /// Where the times at the beginning and the end of `pass` are to be noted.
    fn times(&mut self, pass: &Pass) -> Option<Times> {
        let _ = pass;
        None
    }

    /// A permutation was composed for the pass that runs `shader` and draws no caster.
    fn composed(&mut self, shader: &str, composed: &Composed) {
        let _ = (shader, composed);
    }
}

/// A pass that casters are drawn into.
pub struct Draws<'a, 'e> {
    pub(crate) shared: &'a mut Shared,
    pub(crate) pass: wgpu::RenderPass<'e>,
    pub(crate) shader: &'a str,
    pub(crate) choices: &'a [(&'a str, &'a str)],
    pub(crate) state: DrawState,
    /// The face that is left out of closed casters.
    pub(crate) hidden: Option<wgpu::Face>,
    /// Members of the pass's own blocks.
    pub(crate) constants: Constants,
    /// The groups that hold the pass's own block, by pipeline.
    pub(crate) groups: HashMap<*const Pipeline, Vec<(u32, wgpu::BindGroup)>>,
}

/// A pipeline for casters, and how its shader was come by.
#[derive(Clone)]
pub struct Prepared {
    /// The pipeline.
    pub pipeline: Arc<Pipeline>,
    /// Its permutation.
    pub composed: Composed,
    /// Which of the layouts the shader reads, in the order of its vertex buffers: the others it does not have.
    pub vertices: Vec<usize>,
}

impl<'e> Draws<'_, 'e> {
    /// The pipeline that draws casters with these values of the shader library's axes (of a material, say), whose vertices lie
    /// in buffers of these layouts, and of which the light can see these sides. Its shader has locations
    /// and further groups as `package::passes::caster` says, or the engine's own module for the same pass.
    ///
    /// # Errors
    /// Values that there are not, and faults of the shaders.
    pub fn pipeline(
        &mut self,
        axes: &[(&str, &str)],
        vertices: &[wgpu::VertexBufferLayout<'_>],
        sides: Sides,
    ) -> Result<Prepared, Error> {
        let pass = [("pass", self.shader)];
        let axes = pass.iter().chain(axes).copied();
        let composed = self
            .shared
            .compose(axes.chain(self.choices.iter().copied()))?;
        let mut state = self.state.clone();
        state.cull = state.cull.or(self.hidden.filter(|_| sides.closed));
        let state = state.facing(sides.mirrored, &composed.permutation);
        let (places, layouts) = vertices_read(&composed.permutation, vertices);
        let pipeline = (self.shared).pipeline(&composed.permutation, state, &layouts)?;
        Ok(Prepared {
            pipeline,
            composed,
            vertices: places,
        })
    }

    /// Has the next draws use `pipeline`: sets it, and the group that holds the pass's block `frame` and its further ones.
    ///
    /// # Errors
    /// A block with members that no pass of casters gives.
    pub fn set(&mut self, pipeline: &Arc<Pipeline>) -> Result<(), Error> {
        self.pass.set_pipeline(&pipeline.pipeline);
        let id = Arc::as_ptr(pipeline);
        if !self.groups.contains_key(&id) {
            let groups = self.own_groups(pipeline)?;
            self.groups.insert(id, groups);
        }
        for (group, bound) in self.groups.get(&id).into_iter().flatten() {
            self.pass.set_bind_group(*group, bound, &[]);
        }
        Ok(())
    }

    fn own_groups(&mut self, pipeline: &Pipeline) -> Result<Vec<(u32, wgpu::BindGroup)>, Error> {
        let program = &pipeline.program;
        let key = &program.permutation.key;
        let mut groups = Vec::new();
        for group in 0..program.groups.len() {
            if program.bindings(group).all(|b| b.name != FRAME) {
                continue;
            }
            let binder = &mut self.shared.binder;
            let bound = binder.bind(program, group, |binder, binding| match binding.kind {
                BindingKind::Uniform(_) => binder.block(key, binding, &self.constants),
                _ => {
                    let problem = "the shader reads it beside `frame`, but a pass of casters gives uniform blocks alone";
                    Err(Error::binding(key, binding, problem))
                }
            })?;
            groups.extend(bound.map(|bound| (group as u32, bound)));
        }
        Ok(groups)
    }

    /// The binder, for the engine's own groups.
    pub fn binder(&mut self) -> &mut Binder {
        &mut self.shared.binder
    }

    /// The pass itself, to set vertex buffers and other groups, and to draw.
    pub fn pass(&mut self) -> &mut wgpu::RenderPass<'e> {
        &mut self.pass
    }
}

/// The binding of a pass's own block.
const FRAME: &str = "frame";
