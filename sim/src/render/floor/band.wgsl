// Straight bands over the faces: joints, wires, tape, walls. Blended as luminance + (1 − hidden share) · what was there.

struct Band {
    // Middle and direction of the centre line.
    @location(0) middle: vec2<f32>,
    @location(1) direction: vec2<f32>,
    @location(2) half_length_m: f32,
    @location(3) half_width_m: f32,
    // How far beyond the band the footprint reaches, across and along.
    @location(4) margin_m: vec2<f32>,
    @location(5) albedo: f32,
    // Contrast at the beginning, along, and at the end.
    @location(6) contrast: vec3<f32>,
    // How much greater the albedo of the face to the left is than that to the right.
    @location(7) step: f32,
    // Share of the light that the band takes away beside it.
    @location(8) shade: f32,
    // 1 if the band ends by coverage, 0 if another one goes on where it ends.
    @location(9) capped: f32,
}

struct Strip {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) line: vec4<f32>,
    @location(1) @interpolate(flat) size: vec2<f32>,
    @location(2) @interpolate(flat) contrast: vec3<f32>,
    @location(3) @interpolate(flat) look: vec4<f32>,
    // From storage it would be loaded pixel by pixel.
    @location(4) @interpolate(flat) sub_frames: u32,
}

@vertex
fn band_corner(@builtin(vertex_index) index: u32, band: Band) -> Strip {
    let side = vec2(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    let left = vec2(-band.direction.y, band.direction.x);
    let corner = band.middle
        + left * side.x * (band.half_width_m + band.margin_m.x)
        + band.direction * side.y * (band.half_length_m + band.margin_m.y);
    return Strip(
        clip_at(corner),
        vec4(band.middle, band.direction),
        vec2(band.half_length_m, band.half_width_m),
        band.contrast,
        vec4(band.albedo, band.step, band.shade, band.capped),
        counted.sub_frames,
    );
}

@fragment
fn band_luminance(strip: Strip) -> @location(0) vec4<f32> {
    let pixel = pixel_at(strip.position);
    let direction = strip.line.zw;
    let left = vec2(-direction.y, direction.x);
    var covered = 0.0;
    var on_the_left = 0.0;
    let share = 1.0 / f32(view.sub_frames);
    var start = place_at(view.sub_frame_ends[0], pixel);
    var place = place_at(view.middle, pixel);
    let sides = sides_at(view.middle, pixel, place);
    var way: Way;
    var exposed_at = 0.0;
    if (ROLLING) {
        way = way_of(pixel);
        exposed_at = exposed_from(pixel);
        start = on_way(way, exposed_at);
        place = on_way(way, exposed_at + 0.5 * view.exposed_share);
    }
    for (var frame = 0u; frame < strip.sub_frames; frame++) {
        var end: vec2<f32>;
        if (ROLLING) {
            end = on_way(way, exposed_at + view.exposed_share * share * f32(frame + 1u));
        } else {
            end = place_at(counted.sub_frame_ends[frame + 1u], pixel);
        }
        let footprint = Footprint(sides[0], sides[1], end - start);
        let from_middle = 0.5 * (start + end) - strip.line.xy;
        let widths = widths_along(left, footprint);
        let across = dot(from_middle, left);
        let ends = band_coverage(dot(from_middle, direction), strip.size.x, widths_along(direction, footprint));
        covered += mix(1.0, ends, strip.look.w) * band_coverage(across, strip.size.y, widths);
        on_the_left += half_plane_coverage(across, widths);
        start = end;
    }
    let across = dot(place - strip.line.xy, left);
    let along = dot(place - strip.line.xy, direction) / (2.0 * strip.size.x) + 0.5;

    // Wear fades over the first and the last quarter of a tile's edge.
    let contrast = mix(strip.contrast.x, strip.contrast.y, smoothstep(0.0, 0.25, along))
        + mix(strip.contrast.z - strip.contrast.y, 0.0, smoothstep(0.0, 0.25, 1.0 - along));
    let mask = contrast * covered * share;
    // Faces are drawn with hard edges; this is what the footprint sees of the other one.
    let other_face = strip.look.y * (on_the_left * share - select(0.0, 1.0, across >= 0.0));
    // The shade is a bell of the band's own width.
    let from_edge = across / (2.0 * strip.size.y);
    let within = select(0.0, 1.0, along >= 0.0 && along <= 1.0);
    let shade = strip.look.z * within * exp(-from_edge * from_edge);

    let luminance = light_at(place) * (strip.look.x * mask + (1.0 - mask) * other_face);
    return vec4(luminance, 0.0, 0.0, 1.0 - (1.0 - mask) * (1.0 - shade));
}
