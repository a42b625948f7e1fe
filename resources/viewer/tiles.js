// Tiles of maps finer than those that the page begins with, loaded as they come into view.
//
// Level 0 is the whole material, each further level half as large. A tile lies in the middle of images of its own,
// with a margin of its neighbours for filters. Finer tiles are drawn first, and what is drawn once stays: the depth
// test keeps coarser ones, and at last the map of the whole, to the pixels that are left.

// Bytes of textures that are kept, and images of how many tiles are read at once.
const TILE_BYTES = 256 * 2 ** 20, AT_ONCE = 6;

// Pixels between the places at which the view is sampled.
const SAMPLE = 24;

// Tiles by their keys, those used last at the end; `textures` is missing while one is read, and null where it cannot be.
const tiles = new Map();

const groupName = () => CHANNELS[state.channel] > 2 ? "surface" : "look_up";
const finestLevel = () => data.pyramid.finest[groupName()];
const layersOf = (group) => group === "surface" ? 3 : data.planes ? data.planes.layers.length : 2;

// Of a tile with its smaller levels: the pair in half floats, all else in bytes.
const bytesOfTile = (group) =>
  (data.pyramid.tile + 2 * data.pyramid.margin) ** 2 * layersOf(group) * 4 / 3 *
  (group === "surface" || data.planes ? 4 : 8);

// Texture coordinates of what is seen at a pixel of the canvas, from its upper left; null beside the sphere. `half` is
// that of the plane, and `scale` a pixel in its units.
function coordinates({ half, scale }, x, y) {
  const right = state.centre[0] + (x - canvas.width / 2) * scale, up = state.centre[1] + (canvas.height / 2 - y) * scale;
  if (!state.sphere) return [0.5 + state.repeats * 0.5 * right / half[0], 0.5 - state.repeats * 0.5 * up / half[1]];
  const length = Math.hypot(right, up, 3), along = 9 / length, inside = along * along - 8;
  if (inside < 0) return null;
  const share = (along - Math.sqrt(inside)) / length;
  const [a, b, c] = [share * right, share * up, 3 - 3 * share];
  return [0.5 + state.repeats * Math.atan2(a, c) * half[1] / half[0] / Math.PI,
    0.5 - state.repeats * Math.asin(Math.min(Math.max(b, -1), 1)) / Math.PI];
}

// The level of detail at a pixel, as `level_of_detail` of the shader has it; null beside the sphere.
function detailAt(view, place, x, y) {
  let most = 1e-9;
  for (const next of [coordinates(view, x + 1, y), coordinates(view, x, y + 1)]) {
    if (!next) return null;
    most = Math.max(most, Math.hypot((next[0] - place[0]) * data.size[0], (next[1] - place[1]) * data.size[1]));
  }
  return Math.log2(most);
}

const alongEdge = (length) =>
  Array.from({ length: Math.ceil(length / SAMPLE) + 1 }, (_, index) => Math.min(index * SAMPLE, length));

// Tiles in view by their keys, each with the part of the canvas that it may cover; those of coarser levels as far as
// they are there already. Null where the map of the whole shows as much.
function tilesInView(coarser) {
  const found = new Map(), { levels } = data.pyramid, finest = finestLevel();
  const view = { half: halfPlane(), scale: perDevicePixel(), group: groupName() };
  const wholeDetail = Math.log2(data.size[0] / (data.planes || data.maps.scale).size[0]);
  for (const y of alongEdge(canvas.height)) for (const x of alongEdge(canvas.width)) {
    const place = coordinates(view, x, y), detail = place && detailAt(view, place, x, y);
    if (detail === null || detail >= wholeDetail) continue;
    const first = Math.min(Math.max(Math.floor(detail) + coarser, finest), levels.length - 1);
    for (let level = first; level < levels.length; ++level) addTile(found, view, level, place, [x, y], level === first);
  }
  return found;
}

// What lies a little beside a plane belongs to its edge.
function addTile(found, { half, scale, group }, level, place, [x, y], isWanted) {
  const { tile, levels } = data.pyramid, size = levels[level], turn = [0, 0], index = [0, 0];
  for (const axis of [0, 1]) {
    const reach = state.sphere ? Infinity : 0.5 * state.repeats;
    const inside = Math.min(Math.max(place[axis], 0.5 - reach), 0.5 + reach - 1e-9);
    if (Math.abs(inside - place[axis]) * 2 * half[axis] / state.repeats > SAMPLE * scale) return;
    turn[axis] = Math.floor(inside);
    index[axis] = Math.floor((inside - turn[axis]) * size[axis] / tile);
  }
  const [column, row] = index, key = `${group}-${level}-${column}-${row}`, id = `${key} ${turn}`;
  if (!isWanted && !tiles.get(key)?.textures) return;
  const entry = found.get(id) || { key, level, column, row, turn, isWanted, box: [x, y, x, y] };
  const [left, top, right, bottom] = entry.box;
  entry.isWanted ||= isWanted;
  entry.box = [Math.min(left, x), Math.min(top, y), Math.max(right, x), Math.max(bottom, y)];
  found.set(id, entry);
}

// The tiles to draw, finest first; a coarser level where the finest would take more memory than there is.
function chooseTiles() {
  if (!data.pyramid || finestLevel() >= data.pyramid.levels.length) return [];
  for (let coarser = 0; ; ++coarser) {
    const found = [...tilesInView(coarser).values()];
    const keys = new Set(found.filter((each) => each.isWanted).map((each) => each.key));
    if (keys.size * bytesOfTile(groupName()) > TILE_BYTES && coarser < data.pyramid.levels.length) continue;
    askFor(found);
    return found.filter((each) => tiles.get(each.key)?.textures).sort((one, other) => one.level - other.level);
  }
}

// Begin to read what is missing, and forget what was not used for long.
function askFor(found) {
  for (const { key } of found) if (tiles.has(key)) tiles.set(key, takenOut(key));
  const reading = () => [...tiles.values()].filter((each) => each.textures === undefined).length;
  const missing = found.filter((each) => each.isWanted && !tiles.has(each.key));
  for (const entry of missing) if (reading() < AT_ONCE && !tiles.has(entry.key)) readTile(entry);
  const used = new Set(found.map((each) => each.key));
  for (const [key, { textures }] of tiles) {
    if (tiles.size * bytesOfTile(groupName()) <= TILE_BYTES) break;
    if (used.has(key) || textures === undefined) continue;
    for (const texture of Object.values(textures || {})) gl.deleteTexture(texture);
    tiles.delete(key);
  }
  canvas.setAttribute("aria-busy", missing.length > 0 || reading() > 0);
}

function takenOut(key) {
  const entry = tiles.get(key);
  tiles.delete(key);
  return entry;
}

async function readTile({ key, level, column, row }) {
  const entry = {}, group = groupName(), layers = Array.from({ length: layersOf(group) }, (_, layer) => layer);
  tiles.set(key, entry);
  try {
    const images = await Promise.all(layers.map((layer) =>
      readImage(`tiles/${group}-${level}-${column}-${row}-${layer}.png`)));
    entry.textures = tileTextures(group, images);
  } catch {
    entry.textures = null;
  }
  changed();
}

async function readImage(name) {
  const image = picture(name);
  await image.decode();
  return image;
}

function tileTextures(group, images) {
  const size = [images[0].naturalWidth, images[0].naturalHeight];
  if (group === "surface" || data.planes) return { [group === "surface" ? group : "planes"]: byteArray(size, images) };
  const { largest, exponents } = data.pyramid;
  return {
    scale_map: decodedTile(size, images[0], { largest, lowest: 0 }),
    exponent_map: decodedTile(size, images[1], { largest: exponents[1], lowest: exponents[0] }),
  };
}

// The part of the canvas that a tile may cover, and where in the texture what it covers lies.
function placeTile(program, { level, column, row, turn, box }) {
  const { tile, margin, levels } = data.pyramid, size = levels[level];
  const inside = [column, row].map((index, axis) => Math.min(tile, size[axis] - index * tile));
  const first = [column, row].map((index, axis) => turn[axis] + index * tile / size[axis]);
  gl.uniform4f(uniform(program, "part"), ...first, inside[0] / size[0], inside[1] / size[1]);
  const whole = inside.map((length) => length + 2 * margin);
  gl.uniform4f(uniform(program, "inner"), ...whole.map((length) => margin / length),
    inside[0] / whole[0], inside[1] / whole[1]);
  gl.scissor(Math.floor(box[0] - SAMPLE), Math.floor(canvas.height - box[3] - SAMPLE),
    Math.ceil(box[2] - box[0] + 2 * SAMPLE), Math.ceil(box[3] - box[1] + 2 * SAMPLE));
}
