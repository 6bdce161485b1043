//! Limits of a device, by WebGPU's names.

macro_rules! limits {
    ($($(#[$doc:meta])* $limit:ident = $name:literal, $default:literal;)+) => {
        /// A limit of WebGPU that a shader may exceed.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum Limit {
            $($(#[$doc])* $limit,)+
        }

        impl Limit {
            /// All limits.
            pub const ALL: &[Self] = &[$(Self::$limit),+];

            /// WebGPU's name for the limit.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$limit => $name,)+
                }
            }

            /// WebGPU's default, which every device offers.
            pub fn webgpu(self) -> u64 {
                match self {
                    $(Self::$limit => $default,)+
                }
            }
        }
    };
}

// <https://gpuweb.github.io/gpuweb/#limits>, without those of textures, draws and dispatches, which concern only
// the host.
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
    /// Attributes that a vertex stage reads, and the number of their locations, counted from 0.
    VertexAttributes = "maxVertexAttributes", 16;
    /// Variables between a vertex and a fragment stage, and the number of their locations, counted from 0.
    InterStageShaderVariables = "maxInterStageShaderVariables", 16;
    /// Colours that a fragment stage writes, as the number of their locations, counted from 0.
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
