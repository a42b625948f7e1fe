// The panel: a row for each value, built anew where the rows change.

const shown = (value) => Number(value.toPrecision(3)).toString();

function slider(parent, { label, doc, unit, low, high, log }, get, set) {
  const to = log ? (value) => Math.log(value / low) / Math.log(high / low) : (value) => (value - low) / (high - low);
  const from = log ? (share) => low * (high / low) ** share : (share) => low + share * (high - low);
  const row = document.createElement("div"), input = document.createElement("input");
  const caption = document.createElement("label"), output = document.createElement("output");
  row.className = "row";
  input.type = "range"; input.min = 0; input.max = 1; input.step = 0.001; input.id = "slider" + slider.count++;
  input.title = caption.title = doc || label;
  caption.htmlFor = input.id;
  caption.textContent = label;
  const tell = () => {
    output.textContent = shown(get()) + (unit || "");
    input.setAttribute("aria-valuetext", output.textContent);
  };
  const show = () => { input.value = to(get()); tell(); };
  input.oninput = () => { set(from(Number(input.value))); tell(); changed(); };
  row.append(caption, input, output);
  parent.append(row);
  show();
  return show;
}
slider.count = 0;

function choice(parent, label, names, get, set) {
  const row = document.createElement("div"), caption = document.createElement("label");
  const select = document.createElement("select");
  row.className = "row";
  select.id = "choice-" + label.replace(/ /g, "-").toLowerCase();
  caption.htmlFor = select.id;
  caption.textContent = label;
  for (const [value, text] of names) select.add(new Option(text, value, false, value === get()));
  select.onchange = () => { set(select.value); changed(); byId(select.id).focus(); };
  row.append(caption, select);
  parent.append(row);
}

const grey = (value) => Array.isArray(value) ? (value[0] + value[1] + value[2]) / 3 : value;

// A colour keeps its tint under the slider, which moves its mean.
function withMean(value, mean) {
  const old = grey(value);
  return old !== 0 ? value.map((channel) => channel * mean / old) : [mean, mean, mean];
}

let showLight = [];
function buildPanel() {
  for (const id of ["light", "channel", "model", "parameters", "display"]) byId(id).replaceChildren();
  const degrees = { unit: "°" };
  showLight = [
    slider(byId("light"), { ...degrees, label: "Azimuth", low: -180, high: 180 }, () => state.azimuth,
      (value) => { state.azimuth = value; }),
    slider(byId("light"), { ...degrees, label: "Elevation", low: 0, high: 90 }, () => state.elevation,
      (value) => { state.elevation = value; }),
  ];
  byId("channels").hidden = data.channels.length < 2;
  choice(byId("channel"), "Show", data.channels, () => state.channel,
    (value) => { state.channel = value; buildPanel(); });
  if (state.channel === "enhanced") {
    slider(byId("channel"), { label: "Strength", low: 0, high: 1 }, () => state.strength,
      (value) => { state.strength = value; });
    slider(byId("channel"), { label: "Sharpness", low: 1, high: 200, log: true }, () => state.sharpness,
      (value) => { state.sharpness = value; });
  }
  choice(byId("model"), "Model", data.models.map((model) => [model.name, model.name.replaceAll("-", " ")]),
    () => state.model, (value) => { state.model = value; buildPanel(); });
  const values = state.values[state.model];
  for (const parameter of data.models.find((model) => model.name === state.model).parameters)
    slider(byId("parameters"), parameter, () => grey(values[parameter.name]), (value) => {
      const old = values[parameter.name];
      values[parameter.name] = Array.isArray(old) ? withMean(old, value) : value;
    });
  slider(byId("display"), { label: "Exposure", unit: " EV", low: -4, high: 4 }, () => state.exposure,
    (value) => { state.exposure = value; });
  slider(byId("display"), { label: "Repeats", unit: "×", low: 1, high: 8 }, () => state.repeats,
    (value) => { state.repeats = value; });
  if (!data.cover)
    choice(byId("display"), "Tiling", [["grid", "Grid"], ["hex", "Hexagonal cells"]],
      () => state.hexagonal ? "hex" : "grid", (value) => { state.hexagonal = value === "hex"; });
  choice(byId("display"), "Tone map", [["neutral", "PBR Neutral"], ["none", "None"]],
    () => state.neutral ? "neutral" : "none", (value) => { state.neutral = value === "neutral"; });
  byId("plane").setAttribute("aria-pressed", !state.sphere);
  byId("sphere").setAttribute("aria-pressed", state.sphere);
}

// What of the resolution is here, and what coding in 8 bits changes.
function resolution() {
  const [shownWidth, shownHeight] = (data.planes || data.maps.scale).size;
  if (shownWidth === data.size[0]) return "";
  if (!data.pyramid) return `, averaged down here to ${shownWidth} × ${shownHeight}`;
  const { finest, levels, error } = data.pyramid, level = levels[finest.look_up];
  const coded = error > 0 ? `, tiles in 8 bits (relative RMSE ${shown(100 * error)} %)` : "";
  if (finest.look_up === 0) return `${coded}`;
  const [fineWidth, fineHeight] = level || [shownWidth, shownHeight];
  return `, averaged down here to ${fineWidth} × ${fineHeight}${level ? coded : ""}`;
}

function showFacts() {
  const [width, height] = data.size;
  const kept = data.kept_percent > 0
    ? ` (the material itself keeps slices for ${shown(data.kept_percent)} % of its tiles)` : "";
  const what = data.planes
    ? `Directional map of ${data.planes.count} planes` + (data.planes.leave_one_out === null
      ? "" : `; held-out error ${shown(data.planes.leave_one_out)} 8-bit levels`)
    : `Shading map (Kautz et al. 2004) from its power-law pair, RMS error ${shown(data.rms)}${kept}`;
  const fit = data.fit ? data.fit + " " : "";
  byId("facts").textContent = `${width} × ${height} texels${resolution()}. ${what}. ${fit}Made with Lightarc.`;
  canvas.setAttribute("aria-label", `${data.name} under a light that can be moved`);
  byId("name").textContent = document.title = data.name;
}

function load() {
  if (!gl) fail("This browser offers no WebGL 2. Update it, or allow hardware acceleration in its settings.");
  if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float"))
    fail("This graphics card cannot draw into half floats (EXT_color_buffer_float). Try another browser.");
  programs.clear();
  tiles.clear();
  textures = decodedMaps();
  draw();
  document.documentElement.dataset.state = "ready";
}

readAddress();
showFacts();
for (const map of [...Object.values(data.maps || {}), data.weights]) if (map) map.images = pictures(map);
for (const map of [data.planes, data.surface, data.cover]) if (map) map.images = map.layers.map(picture);
if (data.planes) data.planes.smallerImages = data.planes.smaller.map(picture);
window.addEventListener("load", () => { load(); buildPanel(); listen(); });
