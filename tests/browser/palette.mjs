// PNG files of 256 colours: a third of the bytes of a screenshot of text and lines, to the eye the same.
import { crc32, deflateSync } from 'node:zlib';

const MOST_COLOURS = 256;

/** The PNG with 256 of its colours; each other one becomes the nearest of them. */
export async function fewColours(page, png) {
  const { width, height, pixels } = await page.evaluate(async base64 => {
    const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
    const canvas = new OffscreenCanvas(image.width, image.height).getContext('2d');
    canvas.drawImage(image, 0, 0);
    const { data } = canvas.getImageData(0, 0, image.width, image.height);
    const colours = Array.from({ length: data.length / 4 }, (_, n) => data[4 * n] << 16 | data[4 * n + 1] << 8 | data[4 * n + 2]);
    return { width: image.width, height: image.height, pixels: colours };
  }, png.toString('base64'));
  const counts = new Map();
  for (const colour of pixels) counts.set(colour, (counts.get(colour) ?? 0) + 1);
  const distance = (a, b) => [16, 8, 0].reduce((sum, shift) => sum + ((a >> shift & 255) - (b >> shift & 255)) ** 2, 0);
  // The next colour is always the one that those before it would show worst: a rare one that is like no other stays.
  const palette = [];
  const nearest = new Map([...counts.keys()].map(colour => [colour, { place: 0, far: Infinity }]));
  while (palette.length < Math.min(MOST_COLOURS, counts.size)) {
    const worst = ([colour, { far }]) => far === Infinity ? counts.get(colour) : far * far * Math.sqrt(counts.get(colour));
    const [next] = [...nearest].reduce((a, b) => worst(b) > worst(a) ? b : a);
    for (const [colour, best] of nearest) {
      const far = distance(colour, next);
      if (far < best.far) nearest.set(colour, { place: palette.length, far });
    }
    palette.push(next);
  }
  // Every row begins with the number of its filter, none.
  const rows = Buffer.alloc(height * (width + 1));
  pixels.forEach((colour, n) => { rows[n + Math.floor(n / width) + 1] = nearest.get(colour).place; });
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  // Eight bits a pixel, which is a place in the palette.
  header.set([8, 3, 0, 0, 0], 8);
  const colours = Buffer.from(palette.flatMap(colour => [colour >> 16, colour >> 8 & 255, colour & 255]));
  const signature = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
  const parts = [['IHDR', header], ['PLTE', colours], ['IDAT', deflateSync(rows, { level: 9 })], ['IEND', Buffer.alloc(0)]];
  return Buffer.concat([signature, ...parts.map(([name, data]) => chunk(name, data))]);
}

/** A part of a PNG file: length, name, data, checksum. */
function chunk(name, data) {
  const named = Buffer.concat([Buffer.from(name, 'latin1'), data]);
  const framed = Buffer.alloc(named.length + 8);
  framed.writeUInt32BE(data.length, 0);
  named.copy(framed, 4);
  framed.writeUInt32BE(crc32(named), named.length + 4);
  return framed;
}
