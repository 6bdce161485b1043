// Dawn's verdicts on shaders: a request a line on standard input, its verdict a line on standard output, after
// the word `verdict`: Dawn itself prints warnings there.
//
// A request is `{"code": WGSL, "buffers": [{"type", "size"}], "pipelines": [[PIPELINE, …], …]}`. Each buffer, by the
// type and the least size of its binding, must be one that can be bound. Of the pipelines in an inner list one must be
// made, and of every list: a fragment stage may fit one of several vertex stages. A pipeline is
// `{"compute": ENTRY}` or `{"vertex": ENTRY, "inputs": [{"location", "format"}], "before": WGSL or none,
// "fragment": ENTRY or none, "outputs": [FORMAT or null]}`; `before` is the module of the vertex stage where
// that is not the shader itself. The layout is the one that WebGPU derives.
// A verdict is `{"refused": null}`, or why: `{"refused": "…"}`.

import { createInterface } from 'node:readline';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const home = process.argv[2];
const { create, globals } = await import(pathToFileURL(join(home, 'node_modules/webgpu/index.js')).href);
Object.assign(globalThis, globals);

// The adapter of the null backend needs no GPU; the device has no feature, and WebGPU's default limits.
const gpu = create(['backend=null']);
const adapter = await gpu.requestAdapter();
if (!adapter) throw new Error('Dawn offers no adapter of its null backend');
const device = await adapter.requestDevice();

/** What `work` is refused for, or null. */
async function refused(work) {
  device.pushErrorScope('validation');
  let thrown = null;
  let made = null;
  try {
    made = work();
  } catch (error) {
    thrown = error.message;
  }
  const error = await device.popErrorScope();
  return { made, why: error?.message ?? thrown };
}

function describe(pipeline, module, before) {
  if (pipeline.compute) {
    return { layout: 'auto', compute: { module, entryPoint: pipeline.compute } };
  }
  const attributes = pipeline.inputs.map(({ location, format }) => ({
    shaderLocation: location,
    format,
    offset: 0,
  }));
  const descriptor = {
    layout: 'auto',
    vertex: {
      module: before ?? module,
      entryPoint: pipeline.vertex,
      buffers: attributes.length ? [{ arrayStride: 16, attributes }] : [],
    },
  };
  if (pipeline.fragment) {
    const targets = pipeline.outputs.map((format) => (format ? { format } : null));
    descriptor.fragment = { module, entryPoint: pipeline.fragment, targets };
  }
  const drawsNothing = !descriptor.fragment?.targets.some((target) => target);
  if (drawsNothing) {
    descriptor.depthStencil = { format: 'depth32float', depthWriteEnabled: true, depthCompare: 'always' };
  }
  return descriptor;
}

async function pipelineRefused(pipeline, module) {
  let before = null;
  if (pipeline.before) {
    const made = await refused(() => device.createShaderModule({ code: pipeline.before }));
    if (made.why) return `the vertex stage before it: ${made.why}`;
    before = made.made;
  }
  const descriptor = describe(pipeline, module, before);
  const made = await refused(() =>
    pipeline.compute ? device.createComputePipeline(descriptor) : device.createRenderPipeline(descriptor),
  );
  return made.why;
}

async function bufferRefused({ type, size }) {
  const usage = type === 'uniform' ? GPUBufferUsage.UNIFORM : GPUBufferUsage.STORAGE;
  const bound = await refused(() => {
    const buffer = { type, minBindingSize: size };
    const entries = [{ binding: 0, visibility: GPUShaderStage.COMPUTE, buffer }];
    const layout = device.createBindGroupLayout({ entries });
    const made = device.createBuffer({ size: Math.ceil(size / 4) * 4, usage });
    device.createBindGroup({ layout, entries: [{ binding: 0, resource: { buffer: made } }] });
    return made;
  });
  bound.made?.destroy();
  return bound.why;
}

async function verdict({ code, buffers, pipelines }) {
  const { made: module, why } = await refused(() => device.createShaderModule({ code }));
  if (why) {
    const info = await module?.getCompilationInfo();
    const error = info?.messages.find((message) => message.type === 'error');
    return error ? `${error.lineNum}:${error.linePos} ${error.message}` : why;
  }
  for (const buffer of buffers) {
    const why = await bufferRefused(buffer);
    if (why) return why;
  }
  for (const alternatives of pipelines) {
    let last = null;
    for (const pipeline of alternatives) {
      last = await pipelineRefused(pipeline, module);
      if (!last) break;
    }
    if (last) return last;
  }
  return null;
}

for await (const line of createInterface({ input: process.stdin })) {
  const why = await verdict(JSON.parse(line));
  process.stdout.write(`verdict ${JSON.stringify({ refused: why })}\n`);
}
process.exit(0);
