//! A device's limits, by WebGPU's names.

macro_rules! limits {
    ($($(#[$doc:meta])* $limit:ident = $name:literal, $default:literal;)+) => {
        /// A limit that a shader may run into, as WebGPU has it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum Limit {
            $($(#[$doc])* $limit,)+
        }

        impl Limit {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$limit),+];

            /// Its name in WebGPU.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$limit => $name,)+
                }
            }

            /// What every WebGPU device has at the least.
            pub fn webgpu(self) -> u64 {
                match self {
                    $(Self::$limit => $default,)+
                }
            }
        }
    };
}

// <https://gpuweb.github.io/gpuweb/#limits>; those of textures, draws and dispatches are the host's alone.
limits! {
    /// Bind groups.
    BindGroups = "maxBindGroups", 4;
    /// Binding numbers in a group, from 0.
    BindingsPerBindGroup = "maxBindingsPerBindGroup", 1000;
    /// Sampled textures in a stage.
    SampledTexturesPerStage = "maxSampledTexturesPerShaderStage", 16;
    /// Samplers in a stage.
    SamplersPerStage = "maxSamplersPerShaderStage", 16;
    /// Storage buffers in a stage.
    StorageBuffersPerStage = "maxStorageBuffersPerShaderStage", 8;
    /// Storage textures in a stage.
    StorageTexturesPerStage = "maxStorageTexturesPerShaderStage", 4;
    /// Uniform buffers in a stage.
    UniformBuffersPerStage = "maxUniformBuffersPerShaderStage", 12;
    /// Bytes of a uniform buffer.
    UniformBufferBindingSize = "maxUniformBufferBindingSize", 65_536;
    /// Bytes of a storage buffer.
    StorageBufferBindingSize = "maxStorageBufferBindingSize", 134_217_728;
    /// Attributes that a vertex stage reads, and their locations, from 0.
    VertexAttributes = "maxVertexAttributes", 16;
    /// Variables between a vertex and a fragment stage, and their locations, from 0.
    InterStageShaderVariables = "maxInterStageShaderVariables", 16;
    /// Colours that a fragment stage writes, by their locations, from 0.
    ColorAttachments = "maxColorAttachments", 8;
    /// Bytes of workgroup memory.
    ComputeWorkgroupStorageSize = "maxComputeWorkgroupStorageSize", 16_384;
    /// Invocations of a workgroup.
    ComputeInvocationsPerWorkgroup = "maxComputeInvocationsPerWorkgroup", 256;
    /// A workgroup's size along x.
    ComputeWorkgroupSizeX = "maxComputeWorkgroupSizeX", 256;
    /// A workgroup's size along y.
    ComputeWorkgroupSizeY = "maxComputeWorkgroupSizeY", 256;
    /// A workgroup's size along z.
    ComputeWorkgroupSizeZ = "maxComputeWorkgroupSizeZ", 64;
}
