// Images of the page as textures.

const uniform = (program, name) => gl.getUniformLocation(program, name);

function compile(vertex, fragment) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost())
      fail("A shader does not compile on this graphics card: " + gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
    fail("A shader does not link on this graphics card: " + gl.getProgramInfoLog(program));
  return program;
}

// Images lie in the data of the page, or beside it where its policy allows none within.
const address = (name) => data.pictures ? "data:image/png;base64," + data.pictures[name] : name;

// Images asked for while the page loads are there when it has loaded, where `load` begins.
function picture(name) {
  const image = new Image();
  image.src = address(name);
  return image;
}

const pictures = (map) => ({ high: picture(map.high), low: picture(map.low) });

function byteTexture(image) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, gl.RGB, gl.UNSIGNED_BYTE, image);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  return texture;
}

// The two bytes put together in half precision, so that filtering and the smaller levels see whole numbers.
function decodedMap(map) {
  const bytes = [byteTexture(map.images.high), byteTexture(map.images.low)];
  const [width, height] = map.size;
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, Math.floor(Math.log2(Math.max(width, height))) + 1, gl.RGBA16F, width, height);
  const target = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, target);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
  const program = compile(SCREEN, DECODE);
  gl.useProgram(program);
  ["high", "low"].forEach((name, unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, bytes[unit]);
    gl.uniform1i(uniform(program, name), unit);
  });
  gl.uniform1f(uniform(program, "largest"), map.largest);
  gl.viewport(0, 0, width, height);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.deleteFramebuffer(target);
  gl.deleteProgram(program);
  bytes.forEach((each) => gl.deleteTexture(each));
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.generateMipmap(gl.TEXTURE_2D);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  return texture;
}

// A tile of a power law in half floats.
function decodedTile([width, height], image, { lowest, largest }) {
  const texture = gl.createTexture(), target = gl.createFramebuffer();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, Math.floor(Math.log2(Math.max(width, height))) + 1, gl.RGBA16F, width, height);
  gl.bindFramebuffer(gl.FRAMEBUFFER, target);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
  if (!programs.has(DECODE_TILE)) programs.set(DECODE_TILE, compile(SCREEN, DECODE_TILE));
  const program = programs.get(DECODE_TILE);
  gl.useProgram(program);
  gl.activeTexture(gl.TEXTURE0);
  const codes = byteTexture(image);
  gl.uniform1i(uniform(program, "codes"), 0);
  gl.uniform1f(uniform(program, "lowest"), lowest);
  gl.uniform1f(uniform(program, "largest"), largest);
  gl.viewport(0, 0, width, height);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.deleteFramebuffer(target);
  gl.deleteTexture(codes);
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.generateMipmap(gl.TEXTURE_2D);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  return texture;
}

// An array of half floats of falling sizes; each layer of a level is { high, low, first, lowest, width }, see
// DECODE_LAYER.
function decodedArray(levels) {
  const texture = gl.createTexture(), target = gl.createFramebuffer(), program = compile(SCREEN, DECODE_LAYER);
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
  gl.texStorage3D(gl.TEXTURE_2D_ARRAY, levels.length, gl.RGBA16F, ...levels[0].size, levels[0].layers.length);
  gl.bindFramebuffer(gl.FRAMEBUFFER, target);
  gl.useProgram(program);
  levels.forEach(({ size, layers }, level) => layers.forEach((layer, index) => {
    gl.viewport(0, 0, ...size);
    gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, texture, level, index);
    const bytes = [layer.high, layer.low].map((image, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      return byteTexture(image);
    });
    gl.uniform1i(uniform(program, "high"), 0);
    gl.uniform1i(uniform(program, "low"), 1);
    gl.uniform1i(uniform(program, "first"), layer.first);
    gl.uniform1f(uniform(program, "lowest"), layer.lowest);
    gl.uniform1f(uniform(program, "width"), layer.width);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    bytes.forEach((each) => gl.deleteTexture(each));
  }));
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.deleteFramebuffer(target);
  gl.deleteProgram(program);
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
  gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER,
    levels.length > 1 ? gl.LINEAR_MIPMAP_LINEAR : gl.LINEAR);
  return texture;
}

// Planes at full size and, from pictures in which they lie below each other, at half, at a quarter … (engine.shading.
// directional.minified): means of planes would be darker than the mean of what they show.
function planeLevels({ size, images, smallerImages }) {
  const layer = (first) => (image) => ({ high: image, low: image, first, lowest: 0, width: 1 / 65535 });
  const levels = [{ size, layers: images.map(layer(0)) }];
  for (let [width, height] = size, first = 0; Math.max(width, height) > 1;) {
    [width, height] = [Math.max(1, width >> 1), Math.max(1, height >> 1)];
    levels.push({ size: [width, height], layers: smallerImages.map(layer(first)) });
    first += height;
  }
  return levels;
}

// Layers of 8 bits as they are.
function byteArray([width, height], images) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
  gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
  gl.texStorage3D(gl.TEXTURE_2D_ARRAY, Math.floor(Math.log2(Math.max(width, height))) + 1, gl.RGBA8, width, height,
    images.length);
  images.forEach((image, layer) =>
    gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, layer, width, height, 1, gl.RGBA, gl.UNSIGNED_BYTE, image));
  gl.generateMipmap(gl.TEXTURE_2D_ARRAY);
  gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  return texture;
}

// Textures by the names of their uniforms.
function decodedMaps() {
  const surface = data.surface ? { surface: byteArray(data.surface.size, data.surface.images) } : {};
  if (data.cover) surface.cover = byteArray(data.cover.size, data.cover.images);
  if (!data.planes)
    return { scale_map: decodedMap(data.maps.scale), exponent_map: decodedMap(data.maps.exponent), ...surface };
  const { lowest, step, size, images } = data.weights;
  const weights = decodedArray([{ size, layers: lowest.map((least, index) =>
    ({ ...images, first: index * size[1], lowest: least, width: step[index] })) }]);
  gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  return { ...surface, planes: decodedArray(planeLevels(data.planes)), plane_weights: weights };
}

