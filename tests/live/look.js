// What a person would stumble over, measured in the page as it is laid out. Text of a page under
// test; each function gives a list of what is wrong.
(() => {
  const seen = (element) => {
    const box = element.getBoundingClientRect();
    return box.width > 0 && box.height > 0 && getComputedStyle(element).visibility !== 'hidden';
  };
  const name = (element) => `${element.tagName.toLowerCase()}${element.id ? '#' + element.id : ''}.${element.getAttribute('class') || ''} "${(element.textContent || '').trim().slice(0, 30)}"`;
  const numbers = (colour) => (colour.match(/[\d.]+/g) || []).map(Number);
  const channel = (value) => { const s = value / 255; return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4; };
  const luminance = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
  const over = (top, below) => { const a = top.length > 3 ? top[3] : 1; return [0, 1, 2].map((i) => a * top[i] + (1 - a) * below[i]); };
  function background(element) {
    const layers = [];
    for (let at = element; at; at = at.parentElement) layers.push(numbers(getComputedStyle(at).backgroundColor));
    const page = matchMedia('(prefers-color-scheme: dark)').matches ? [0, 0, 0] : [255, 255, 255];
    return layers.reverse().reduce((below, layer) => (layer.length ? over(layer, below) : below), page);
  }
  function opacity(element) {
    let all = 1;
    for (let at = element; at; at = at.parentElement) all *= Number(getComputedStyle(at).opacity);
    return all;
  }
  window.look = {
    overflow() {
      const wide = document.documentElement.clientWidth, found = [];
      if (document.documentElement.scrollWidth > wide) found.push(`the page is ${document.documentElement.scrollWidth} wide in ${wide}`);
      for (const each of document.querySelectorAll('body *')) {
        const box = each.getBoundingClientRect();
        if (seen(each) && (box.right > wide + 1 || box.left < -1)) found.push(`${name(each)} from ${box.left} to ${box.right}`);
      }
      return found;
    },
    cut() {  // text that does not fit into its box
      return [...document.querySelectorAll('.value, .top, button, .pose div, .state, td, label, .notice, .lost')]
        .filter((each) => seen(each) && each.scrollWidth > each.clientWidth + 1)
        .map((each) => `${name(each)}: ${each.scrollWidth} in ${each.clientWidth}`);
    },
    targets(least) {
      return [...document.querySelectorAll('button, select, input, a, summary')].filter(seen)
        .map((each) => [each, each.getBoundingClientRect()])
        .filter(([, box]) => box.width < least || box.height < least)
        .map(([each, box]) => `${name(each)}: ${box.width} x ${box.height}`);
    },
    contrast(least) {  // WCAG 2.1, 1.4.3; large text by its rule
      const found = [], walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
      let looked = 0;
      while (walker.nextNode()) {
        const each = walker.currentNode.parentElement;
        if (!walker.currentNode.textContent.trim() || !seen(each) || each.closest('script, style, title, noscript')) continue;
        const style = getComputedStyle(each), below = background(each);
        let ink = numbers(each instanceof SVGElement ? style.fill : style.color);
        ink = over([ink[0], ink[1], ink[2], (ink.length > 3 ? ink[3] : 1) * opacity(each)], below);
        const [low, high] = [luminance(ink), luminance(below)].sort((a, b) => a - b);
        const ratio = (high + 0.05) / (low + 0.05);
        ++looked;
        if (ratio < least) found.push(`${ratio.toFixed(2)} : 1 of ${name(each)}`);
      }
      if (looked < 30) found.push(`only ${looked} texts were looked at`);
      return found;
    },
    unexplained() {  // buttons that cannot be pressed and do not say why
      return [...document.querySelectorAll('button')].filter((each) => seen(each) && (each.disabled || each.getAttribute('aria-disabled') === 'true'))
        .filter((each) => !/^Not now: .{8,}\.$/.test(each.title) || !each.querySelector('small').textContent.trim()).map(name);
    },
  };
  return true;
})()
