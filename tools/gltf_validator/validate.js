// Checks .glb and .gltf files with Khronos' validator: node validate.js FILE...
// Prints a line a message; exits with 1 if a file has an error or a warning.
// Set up with: npm ci --prefix tools/gltf_validator
const fs = require('fs');
const path = require('path');
const validator = require('gltf-validator');

async function validate(file) {
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
    uri: path.basename(file),
    externalResourceFunction: async (uri) =>
        new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri)))),
  });
  for (const m of report.issues.messages) console.log(`${file}: ${m.code} ${m.pointer}: ${m.message}`);
  const {numErrors, numWarnings} = report.issues;
  const {totalVertexCount, totalTriangleCount} = report.info ?? {};
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ` +
              `${totalVertexCount} vertices, ${totalTriangleCount} triangles`);
  return numErrors + numWarnings;
}

async function main(files) {
  let bad = files.length === 0 ? 1 : 0;
  for (const file of files) bad += await validate(file);
  process.exit(bad ? 1 : 0);
}

main(process.argv.slice(2));
