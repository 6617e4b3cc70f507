// Every file named must be glTF without an error or a warning: validate.mjs FILE.glb...
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { basename } from "node:path";

const require = createRequire(process.env.GLTF_PACKAGES + "/");
const validator = require("gltf-validator");
let bad = process.argv.length < 3;
for (const file of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), { uri: basename(file) });
  const { numErrors, numWarnings, numInfos } = report.issues;
  const { totalVertexCount, totalTriangleCount } = report.info;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos; ` +
              `${totalVertexCount} vertices, ${totalTriangleCount} triangles`);
  for (const m of report.issues.messages) console.log(`  ${m.code} ${m.pointer ?? ""}: ${m.message}`);
  bad ||= numErrors + numWarnings > 0 || !(totalTriangleCount > 0);
}
process.exit(bad ? 1 : 0);
