// Bundles the viewer with the parts of three.js that it uses, for the page to hold inline.

import { createHash } from 'node:crypto';
import { readFileSync, writeFileSync } from 'node:fs';
import { build } from 'esbuild';

const TARGET = '../walkergen/files/assets/viewer.min.js';

const SOURCES = ['plate.js', 'run.js', 'viewer.js'];

const sources = createHash('sha256');
for (const name of SOURCES) sources.update(readFileSync(name));
const three = JSON.parse(readFileSync('node_modules/three/package.json', 'utf8'));
const licence = readFileSync('node_modules/three/LICENSE', 'utf8').trim();
const banner = `/*
viewer/, sha256 ${sources.digest('hex')}
with parts of three.js ${three.version}:

${licence}
*/`;

const built = await build({
  entryPoints: ['viewer.js'],
  bundle: true,
  minify: true,
  format: 'iife',
  globalName: 'walkergenViewer',
  target: 'es2022',
  charset: 'ascii',
  legalComments: 'none', // the banner holds the licence, whole
  banner: { js: banner },
  write: false,
});
const text = built.outputFiles[0].text;
if (/<\/script|<!--/i.test(text)) throw new Error('the bundle would end its own script element');
writeFileSync(TARGET, text);
console.log(`${TARGET}: ${Buffer.byteLength(text)} bytes`);
