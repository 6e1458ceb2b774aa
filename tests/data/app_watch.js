// Collects script errors, and frames of the 3D view in which no part is drawn.
window.troubles = [];
addEventListener('error', ({ message }) => troubles.push(message));
addEventListener('unhandledrejection', ({ reason }) => troubles.push(String(reason)));
const own = WebGL2RenderingContext.prototype;
const { clear, drawArrays } = own;
own.clear = function (...given) {
  this.hasPart = false;
  queueMicrotask(() => this.hasPart || troubles.push('a frame without a part'));
  clear.apply(this, given);
};
own.drawArrays = function (mode, ...rest) {
  this.hasPart ||= mode === this.TRIANGLES;
  drawArrays.call(this, mode, ...rest);
};
