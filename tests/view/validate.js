// node validate.js FILE MODULES: prints the counts of the Khronos validator; exit status 1 with errors, 3 without it.
const fs = require("fs");
let validator;
try { validator = require(require.resolve("gltf-validator", { paths: [process.argv[3] || "."] })); } catch { process.exit(3); }
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[2]))).then((report) => {
  console.log(JSON.stringify(report.issues.messages.filter((m) => m.severity < 2).slice(0, 5)), report.issues.numErrors, "errors", report.issues.numWarnings, "warnings");
  process.exit(report.issues.numErrors ? 1 : 0);
});
