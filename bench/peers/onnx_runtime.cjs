// SPDX-License-Identifier: Apache-2.0
// node onnx_runtime.cjs MODEL.onnx LOOKS: milliseconds of each of so many looks at a patch, by ONNX Runtime on one thread, a number a line. Exit
// status 77 where it is missing (tests/onnx: npm ci --ignore-scripts, and scripts/fetch_onnx_runtime.sh).
const path = require("node:path");

let runtime;
try {
  runtime = require(path.join(__dirname, "../../tests/onnx/node_modules/onnxruntime-node"));
} catch (error) {
  console.error(error.message.split("\n")[0]);
  process.exit(77);
}

async function main(model, looks) {
  const session = await runtime.InferenceSession.create(model, { intraOpNumThreads: 1, interOpNumThreads: 1, graphOptimizationLevel: "all" });
  const shape = session.inputMetadata[0].shape;
  const numbers = new Float32Array(shape.reduce((product, size) => product * size, 1));
  for (let i = 0; i < numbers.length; ++i) numbers[i] = Math.sin(i * 12.9898) * 0.999;
  const patch = { [session.inputNames[0]]: new runtime.Tensor("float32", numbers, shape) };
  for (let i = 0; i < 10; ++i) await session.run(patch);
  const times = [];
  for (let i = 0; i < looks; ++i) {
    const begun = process.hrtime.bigint();
    await session.run(patch);
    times.push(Number(process.hrtime.bigint() - begun) / 1e6);
  }
  console.log(times.join("\n"));
}

main(process.argv[2], Number(process.argv[3])).catch((error) => {
  console.error(error);
  process.exit(1);
});
