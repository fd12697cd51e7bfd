/** Examines the pixels of pictures, which the browser decodes on an empty page. */

import { launch } from "./browser.js";

async function inBrowser(pictures, look, argument) {
  const page = await (await launch()).newPage();
  try {
    const encoded = pictures.map((png) => png.toString("base64"));
    return await page.evaluate(
      async ({ encoded, look, argument }) => {
        const decoded = [];
        for (const one of encoded) {
          const image = new Image();
          image.src = `data:image/png;base64,${one}`;
          await image.decode();
          const canvas = document.createElement("canvas");
          canvas.width = image.width;
          canvas.height = image.height;
          const context = canvas.getContext("2d");
          context.drawImage(image, 0, 0);
          decoded.push(context.getImageData(0, 0, image.width, image.height));
        }
        return new Function("pictures", "argument", `return (${look})(pictures, argument)`)(
          decoded,
          argument,
        );
      },
      { encoded, look: look.toString(), argument },
    );
  } finally {
    await page.close();
  }
}

/** Share of the pixels in which two pictures of the same size clearly differ, from 0 to 1. */
export function difference(one, other) {
  return inBrowser([one, other], ([a, b]) => {
    if (a.width !== b.width || a.height !== b.height) {
      throw new Error(`${a.width} x ${a.height} beside ${b.width} x ${b.height}`);
    }
    let differ = 0;
    for (let at = 0; at < a.data.length; at += 4) {
      const by = [0, 1, 2].map((part) => Math.abs(a.data[at + part] - b.data[at + part]));
      differ += Math.max(...by) > 24 ? 1 : 0;
    }
    return (4 * differ) / a.data.length;
  });
}

/** Number of pixels of the hue of each of these colours (#rrggbb), however light or dark they are. */
export function ofHues(png, colors) {
  return inBrowser(
    [png],
    ([picture], colors) => {
      const polar = (red, green, blue) => {
        const most = Math.max(red, green, blue);
        const chroma = most - Math.min(red, green, blue);
        let sector = (red - green) / chroma + 4;
        if (most === red) {
          sector = ((green - blue) / chroma + 6) % 6;
        } else if (most === green) {
          sector = (blue - red) / chroma + 2;
        }
        return { hue: 60 * sector, vivid: chroma > 36 };
      };
      const hues = colors.map((color) => {
        const parts = [1, 3, 5].map((at) => Number.parseInt(color.slice(at, at + 2), 16));
        return polar(...parts).hue;
      });
      const counts = hues.map(() => 0);
      for (let at = 0; at < picture.data.length; at += 4) {
        const { hue, vivid } = polar(...picture.data.slice(at, at + 3));
        hues.forEach((wanted, index) => {
          const apart = Math.abs(((hue - wanted + 540) % 360) - 180);
          counts[index] += vivid && apart < 8 ? 1 : 0;
        });
      }
      return counts;
    },
    colors,
  );
}

/** Width and height; throws unless it is a picture. */
export const size = (png) => inBrowser([png], ([{ width, height }]) => ({ width, height }));
