// Validate glTF files with Khronos' validator: node validate.cjs MODULES FILE...
// Prints one JSON line a file; ends 1 if any has an error.
const fs = require("fs");
const path = require("path");
const [modules, ...files] = process.argv.slice(2);
const validator = require(path.join(modules, "node_modules", "gltf-validator"));

(async () => {
  let failed = false;
  for (const file of files) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { maxIssues: 100 });
    const errors = report.issues.messages.filter((m) => m.severity === 0);
    console.log(JSON.stringify({ file, errors: report.issues.numErrors, warnings: report.issues.numWarnings, messages: errors.slice(0, 5) }));
    failed = failed || report.issues.numErrors > 0;
  }
  process.exit(failed ? 1 : 0);
})();
