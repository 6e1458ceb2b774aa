// Clicks what is seen at random, and writes random values.
let [seed, count, skip, done] = arguments;
const random = () => ((seed = (seed * 48271) % 2147483647) - 1) / 2147483646;
const one = (list) => list[Math.floor(random() * list.length)];
const steps = {
  range: (each) => each.min - 0 + random() * (each.max - each.min),
  number: () => (60 * random()).toPrecision(3), text: () => one(['LEA', '', '[1, 2]', 'x']),
};
const click = () => {
  const each = one([...document.querySelectorAll('button, summary, select, input')].filter((each) =>
    each.checkVisibility() && !each.disabled && !each.matches(skip)));
  if (each.tagName === 'SELECT') each.value = one([...each.options]).value;
  else if (steps[each.type]) each.value = steps[each.type](each);
  else each.click();
  for (const name of ['input', 'change']) each.dispatchEvent(new Event(name, { bubbles: true }));
  if (--count) setTimeout(click, 100);
  else {
    document.querySelector('#afresh').click(); // so that the server keeps a walker that can be built
    setTimeout(() => done(troubles), 2000);
  }
};
click();
