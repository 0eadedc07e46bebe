// SPDX-License-Identifier: Apache-2.0
// node run_onnx.cjs (MODEL INPUTS OUTPUT)...: runs an ONNX file in ONNX Runtime on each of the inputs (float32, one after another), and
// writes the numbers of all its outputs, in their order, as float32. Exit status 77 where ONNX Runtime is missing.
const fs = require("node:fs");

let runtime;
try {
  runtime = require("onnxruntime-node");
} catch (error) {
  console.error(error.message.split("\n")[0]);
  process.exit(77);
}

async function run(model, inputs, output) {
  const session = await runtime.InferenceSession.create(model, { intraOpNumThreads: 1 });
  const shape = session.inputMetadata[0].shape;
  const count = shape.reduce((product, size) => product * size, 1);
  const bytes = fs.readFileSync(inputs);
  const numbers = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
  const parts = [];
  for (let first = 0; first < numbers.length; first += count) {
    const patch = new runtime.Tensor("float32", numbers.subarray(first, first + count), shape);
    const answers = await session.run({ [session.inputNames[0]]: patch });
    for (const name of session.outputNames) parts.push(Buffer.from(new Float32Array(answers[name].data).buffer));
  }
  fs.writeFileSync(output, Buffer.concat(parts));
}

async function main(files) {
  for (let i = 0; i + 2 < files.length; i += 3) {
    try {
      await run(files[i], files[i + 1], files[i + 2]);
    } catch (error) {
      throw new Error(`${files[i]}: ${error.message}`);
    }
  }
}

main(process.argv.slice(2)).catch((error) => {
  console.error(error);
  process.exit(1);
});
