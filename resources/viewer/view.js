// The state of the page, what of it is drawn, and gestures on the picture.

function fail(sentence) {
  byId("failure").textContent = sentence;
  byId("failure").style.display = "grid";
  document.documentElement.dataset.state = "failed: " + sentence;
  throw new Error(sentence);
}

// Half the height of the picture where all is shown, in halves of the height of a square plane.
const WHOLE = 1.15;

const start = () => ({
  sphere: false, azimuth: 50, elevation: 45, exposure: 0, repeats: 1, hexagonal: false, neutral: true, model: data.brdf,
  zoom: 1, centre: [0, 0], moves: "light", channel: "picture", strength: 0.5, sharpness: 60, width_mm: data.width_mm,
  values: Object.fromEntries(data.models.map((model) => [model.name,
    Object.fromEntries(model.parameters.map((parameter) => [parameter.name, parameter.value]))])),
});
let state = start();
const gl = canvas.getContext("webgl2", { antialias: false, alpha: false });
const programs = new Map();
let textures = {};

function lightDirection() {
  const azimuth = state.azimuth * Math.PI / 180, elevation = state.elevation * Math.PI / 180;
  return [Math.cos(azimuth) * Math.cos(elevation), Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation)];
}

const span = () => WHOLE / state.zoom;

// The plane's extent to the right and upwards: it fits into the picture.
function halfPlane() {
  const [width, height] = data.size, narrow = Math.min(1, canvas.clientWidth / canvas.clientHeight);
  return width > height ? [narrow, narrow * height / width] : [narrow * width / height, narrow];
}

function setUniforms(program, model) {
  const all = Array.from({ length: 64 }, (_, index) => 90 - index / 64 * 90);
  const arc = data.planes ? all : data.elevation_deg.length ? data.elevation_deg : [90];
  gl.uniform3fv(uniform(program, "arc"), arc.flatMap((degrees) =>
    [Math.cos(degrees * Math.PI / 180), 0, Math.sin(degrees * Math.PI / 180)]));
  gl.uniform1i(uniform(program, "arc_count"), arc.length);
  gl.uniform1f(uniform(program, "fixed_sigma"), data.sigma || 0);
  gl.uniform1f(uniform(program, "r_max"), data.r_max);
  gl.uniform2f(uniform(program, "half_picture"), canvas.width / 2, canvas.height / 2);
  gl.uniform2fv(uniform(program, "half_plane"), halfPlane());
  gl.uniform2fv(uniform(program, "centre"), state.centre);
  gl.uniform1f(uniform(program, "span"), span());
  gl.uniform3fv(uniform(program, "light"), lightDirection());
  gl.uniform1f(uniform(program, "gain"), 2 ** state.exposure);
  gl.uniform1f(uniform(program, "repeats"), state.repeats);
  gl.uniform1i(uniform(program, "is_hexagonal"), state.hexagonal);
  gl.uniform1i(uniform(program, "sphere"), state.sphere);
  gl.uniform1i(uniform(program, "neutral_curve"), state.neutral);
  gl.uniform1i(uniform(program, "channel"), CHANNELS[state.channel]);
  gl.uniform1f(uniform(program, "strength"), state.strength);
  gl.uniform1f(uniform(program, "sharpness"), state.sharpness);
  if (data.planes) gl.uniform1f(uniform(program, "lowest_cosine"), data.planes.lowest);
  for (const [name, value] of Object.entries(state.values[model.name])) {
    const where = uniform(program, "brdf_" + name);
    if (Array.isArray(value)) gl.uniform3fv(where, value); else gl.uniform1f(where, value);
  }
}

function bind(program, maps) {
  Object.entries(maps).forEach(([name, texture], unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    const isArray = data.planes || name === "surface" || name === "cover";
    gl.bindTexture(isArray ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D, texture);
    gl.uniform1i(uniform(program, name), unit);
  });
}

function draw() {
  const model = data.models.find((each) => each.name === state.model);
  if (!programs.has(model.name)) programs.set(model.name, compile(vertexSource(model), fragmentSource(model)));
  const program = programs.get(model.name);
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  keepInView();
  const chosen = state.hexagonal ? [] : chooseTiles();
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.useProgram(program);
  setUniforms(program, model);
  gl.clear(gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.SCISSOR_TEST);
  gl.uniform1i(uniform(program, "is_tile"), true);
  for (const tile of chosen) {
    bind(program, { ...textures, ...tiles.get(tile.key).textures });
    placeTile(program, tile);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
  gl.disable(gl.SCISSOR_TEST);
  gl.uniform1i(uniform(program, "is_tile"), false);
  bind(program, textures);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  gl.disable(gl.DEPTH_TEST);
  placeSun();
  placeScale();
  byId("zoom").textContent = shown(state.zoom) + " ×";
}

const lightRadius = () => Math.min(canvas.clientWidth, canvas.clientHeight) / 2 / WHOLE;

function placeSun() {
  const [x, y] = lightDirection(), sun = byId("sun");
  sun.style.left = canvas.clientWidth / 2 + x * lightRadius() + "px";
  sun.style.top = canvas.clientHeight / 2 - y * lightRadius() + "px";
}

// Pixels of the page for a millimetre of the sample, 0 where its width is not known.
const pixelsPerMillimetre = () =>
  state.width_mm > 0 ? halfPlane()[0] * canvas.clientHeight / span() / (state.width_mm * state.repeats) : 0;

// The longest length of 1, 2 or 5 times a power of ten that a quarter of the picture's width has room for.
function roundLength(most_mm) {
  const power = 10 ** Math.floor(Math.log10(most_mm));
  return [5, 2, 1].map((digit) => digit * power).find((length) => length <= most_mm * (1 + 1e-9)) || power;
}

function lengthText(length_mm) {
  for (const [unit, of_mm] of [["m", 1000], ["cm", 10], ["mm", 1]])
    if (length_mm >= of_mm * (1 - 1e-9)) return shown(length_mm / of_mm) + " " + unit;
  return shown(1000 * length_mm) + " µm";
}

function placeScale() {
  const bar = byId("scale"), density = pixelsPerMillimetre();
  bar.hidden = !density || state.sphere;
  if (bar.hidden) return;
  const length_mm = roundLength(canvas.clientWidth / 4 / density);
  bar.style.width = length_mm * density + "px";
  bar.firstElementChild.textContent = lengthText(length_mm);
  bar.setAttribute("aria-label", "Scale bar of " + lengthText(length_mm));
}

// Before the maps are there, nothing is drawn.
let pending = false;
function changed() {
  if (pending || !Object.keys(textures).length) return;
  pending = true;
  requestAnimationFrame(() => { pending = false; draw(); });
}

// The zoom at which a texel covers one pixel of the screen, on the sphere where it faces the viewer.
function zoomOfTexels() {
  const half = halfPlane(), across = data.size[0] * state.repeats / half[0];
  return WHOLE / canvas.height * across * (state.sphere ? 4 / 3 * half[1] / Math.PI : 1);
}

const zoomLimits = () => [Math.min(1, zoomOfTexels()), Math.max(8, 16 * zoomOfTexels())];

function keepInView() {
  const [least, most] = zoomLimits(), half = state.sphere ? [WHOLE, WHOLE] : halfPlane();
  state.zoom = Math.min(Math.max(state.zoom, least), most);
  state.centre = state.centre.map((value, axis) => Math.min(Math.max(value, -half[axis]), half[axis]));
}

// Pixels of the page from the middle of the picture, to the right and up.
function fromMiddle({ clientX, clientY }) {
  const box = canvas.getBoundingClientRect();
  return [clientX - box.left - box.width / 2, box.top + box.height / 2 - clientY];
}

const perPixel = () => span() / (canvas.clientHeight / 2);
const perDevicePixel = () => span() / (canvas.height / 2);

// What lies at the pixel `at` stays there.
function zoomBy(factor, at = [0, 0]) {
  const [least, most] = zoomLimits(), before = perPixel();
  state.zoom = Math.min(Math.max(state.zoom * factor, least), most);
  const gained = before - perPixel();
  state.centre = state.centre.map((value, axis) => value + at[axis] * gained);
  changed();
}

function pan(right, up) {
  state.centre = [state.centre[0] - right * perPixel(), state.centre[1] - up * perPixel()];
  changed();
}

function showAll() {
  state.zoom = 1;
  state.centre = [0, 0];
  changed();
}

function moveLight(x, y) {
  const length = Math.hypot(x, y);
  if (length > 0) state.azimuth = Math.atan2(y, x) * 180 / Math.PI;
  state.elevation = Math.acos(Math.min(1, length)) * 180 / Math.PI;
  showLight.forEach((show) => show());
  changed();
}

// Pointers that are down, by their numbers: where they were seen last, and for one that moves the light where that
// stood before, for a second finger takes it back there.
const pointers = new Map();

function pressed(event) {
  canvas.focus({ preventScroll: true });
  canvas.setPointerCapture(event.pointerId);
  const light = state.moves === "light" && event.button === 0 && !event.shiftKey && pointers.size === 0;
  for (const pointer of pointers.values()) {
    Object.assign(state, pointer.light);
    pointer.light = null;
  }
  const { azimuth, elevation } = state;
  pointers.set(event.pointerId, { at: fromMiddle(event), light: light ? { azimuth, elevation } : null });
  if (light) dragged(event);
  else showLight.forEach((show) => show());
  event.preventDefault();
}

const middle = (places) => [0, 1].map((axis) => places.reduce((sum, at) => sum + at[axis], 0) / places.length);
const apart = ([one, other]) => other ? Math.hypot(one[0] - other[0], one[1] - other[1]) : 0;

// One pointer moves the light or the picture; two or more move the picture and draw it apart.
function dragged(event) {
  const pointer = pointers.get(event.pointerId);
  if (!pointer) return;
  const places = () => [...pointers.values()].map((each) => each.at);
  const before = places();
  pointer.at = fromMiddle(event);
  if (pointer.light) return moveLight(...pointer.at.map((value) => value / lightRadius()));
  const after = places(), [from, to] = [middle(before), middle(after)];
  pan(to[0] - from[0], to[1] - from[1]);
  if (apart(before) > 0 && apart(after) > 0) zoomBy(apart(after) / apart(before), to);
}

function released(event) {
  pointers.delete(event.pointerId);
}

function wheeled(event) {
  const pixels = event.deltaY * [1, 16, canvas.clientHeight][event.deltaMode];
  zoomBy(Math.exp(-pixels * (event.ctrlKey ? 0.01 : 0.002)), fromMiddle(event));
  event.preventDefault();
}

// Said to those who do not see the picture.
function say(words) {
  byId("status").textContent = words;
}

const sayLight = () => say(`Light at azimuth ${Math.round(state.azimuth)}°, elevation ${Math.round(state.elevation)}°`);
const sayView = () => say(`Zoom ${shown(state.zoom)}`);

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const KEYS = {
  "+": () => zoomBy(1.25), "=": () => zoomBy(1.25), "-": () => zoomBy(0.8), "0": showAll,
  "1": () => zoomBy(zoomOfTexels() / state.zoom),
  m: () => chooseMoves(state.moves === "light" ? "view" : "light"), p: () => showPanel(byId("panel").hidden),
};

function keyed(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const step = ARROWS[event.key], act = KEYS[event.key.toLowerCase()];
  if (!step && !act) return;
  event.preventDefault();
  if (act) {
    act();
    return sayView();
  }
  if (event.shiftKey || state.moves === "view") return pan(-48 * step[0], -48 * step[1]);
  const [x, y] = lightDirection();
  moveLight(x + 0.05 * step[0], y + 0.05 * step[1]);
  sayLight();
}

function chooseMoves(what) {
  state.moves = what;
  canvas.classList.toggle("view", what === "view");
  for (const each of ["light", "view"]) byId("mode-" + each).setAttribute("aria-pressed", each === what);
}

function showPanel(open) {
  byId("panel").hidden = !open;
  byId("toggle").setAttribute("aria-expanded", open);
  byId("toggle").textContent = open ? "Hide panel" : "Show panel";
  changed();
}

function listen() {
  canvas.addEventListener("pointerdown", pressed);
  canvas.addEventListener("pointermove", dragged);
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) canvas.addEventListener(end, released);
  canvas.addEventListener("wheel", wheeled, { passive: false });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("keydown", keyed);
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", load);
  for (const shape of ["plane", "sphere"])
    byId(shape).onclick = () => { state.sphere = shape === "sphere"; showAll(); buildPanel(); };
  for (const what of ["light", "view"]) byId("mode-" + what).onclick = () => chooseMoves(what);
  for (const [id, key] of [["smaller", "-"], ["larger", "+"], ["fit", "0"], ["texels", "1"]])
    byId(id).onclick = () => { KEYS[key](); sayView(); };
  byId("toggle").onclick = () => showPanel(byId("panel").hidden);
  byId("reset").onclick = () => { state = start(); chooseMoves(state.moves); buildPanel(); changed(); };
  window.addEventListener("resize", changed);
}

// A state to begin with, as in index.html#sphere=1&azimuth=30&elevation=60&neutral=0&panel=0
function readAddress() {
  for (const [name, text] of new URLSearchParams(location.hash.slice(1))) {
    const number = Number(text);
    if (name === "channel" && data.channels.some(([channel]) => channel === text)) state.channel = text;
    if (!Number.isFinite(number)) continue;
    if (["sphere", "neutral", "hexagonal"].includes(name)) state[name] = number !== 0;
    if (["azimuth", "elevation", "exposure", "repeats", "zoom", "width_mm"].includes(name)) state[name] = number;
    if (name === "panel" && number === 0) showPanel(false);
  }
}
