// The npm package's own check over the cases that tests/library/portability.rs writes; the same in Node and in a page.

/**
 * Every stage of each case beside the reference, and the whole map beside that of the reference outside WebAssembly, until the seconds are
 * over. `load(name)` gives the bytes of a file.
 */
export async function checked({ StereoMatcher }, device, load, seconds) {
  const cases = JSON.parse(new TextDecoder().decode(await load("cases.json")));
  const end = Date.now() + 1000 * seconds;
  const result = { done: 0, cases: cases.length, stages: 0, values: 0, faults: [] };
  for (const [nth, one] of cases.entries()) {
    if (Date.now() > end || result.faults.length > 4) break;
    const name = `${nth}, ${one.width}x${one.height}, ${JSON.stringify(one.options)}`;
    try {
      await check(StereoMatcher, device, load, nth, one, name, result);
    } catch (error) {
      result.faults.push(`case ${name}: ${error.message ?? error}`);
    }
    result.done += 1;
  }
  return result;
}

async function check(StereoMatcher, device, load, nth, one, name, result) {
  const [left, right, map] = await Promise.all(["left", "right", "map"].map((file) => load(`${nth}-${file}`)));
  const samples = (bytes) => (one.format.endsWith("16") ? new Uint16Array(bytes.buffer) : bytes);
  const pair = [samples(left), samples(right)];
  const matcher = await StereoMatcher.create({ ...one, device });
  const stages = await matcher.check(...pair);
  if (stages.length < 3) throw new Error(`only ${stages.length} stages were compared`);
  for (const { stage, compared, different, first } of stages) {
    if (!compared || different) throw new Error(`${stage}: ${different} of ${compared} differ, first ${JSON.stringify(first)}`);
    result.stages += 1;
    result.values += compared;
  }
  const { disparities } = await matcher.compute(...pair);
  const expected = new Int16Array(map.buffer);
  if (expected.length !== disparities.length) throw new Error(`${disparities.length} pixels, not ${expected.length}`);
  const wrong = expected.findIndex((value, i) => value !== disparities[i]);
  if (wrong >= 0) throw new Error(`the map differs at pixel ${wrong}: ${disparities[wrong]}, not ${expected[wrong]}`);
  await matcher.free();
}
