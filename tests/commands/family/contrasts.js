// Contrast (WCAG 2.2, relative luminance) of every text that is shown with the ground below it.
// Body of a function; returns a list of {text, contrast}. Grounds are plain colours here; of a text
// in an SVG picture, the page's. What is hidden from readers is a mark, not text.
const canvas = document.createElement('canvas').getContext('2d', { willReadFrequently: true });

function rgba(colour) {
  canvas.clearRect(0, 0, 1, 1);
  canvas.fillStyle = colour;
  canvas.fillRect(0, 0, 1, 1);
  return [...canvas.getImageData(0, 0, 1, 1).data].map((value) => value / 255);
}

function luminance(colour) {
  const [r, g, b] = colour.map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

const over = (front, ground) =>
  [0, 1, 2].map((i) => front[3] * front[i] + (1 - front[3]) * ground[i]);

function ground(element) {
  if (!element) return rgba('Canvas');
  return over(rgba(getComputedStyle(element).backgroundColor), ground(element.parentElement));
}

const found = [];
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
while (walker.nextNode()) {
  const text = walker.currentNode.textContent.trim();
  const element = walker.currentNode.parentElement;
  if (!text || element.closest('script, style, title, option, :disabled, [aria-hidden]')) continue;
  if (!element.checkVisibility()) continue;
  const style = getComputedStyle(element);
  const below = ground(element);
  const colour = over(rgba(element.closest('svg') ? style.fill : style.color), below);
  const [low, high] = [luminance(colour), luminance(below)].sort((a, b) => a - b);
  found.push({ text: text.slice(0, 60), contrast: (high + 0.05) / (low + 0.05) });
}
return found;
