#include "fsw/records/record_type.hpp"

#include <iterator>
#include <type_traits>

namespace ilp {
namespace {

#define F(member, unit, description) ILP_FIELD(R, member, unit, description)

template <typename Record>
struct Fields;

template <>
struct Fields<CameraRecord> {
  using R = CameraRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "1 the camera, 2 the nominal one where the intrinsics were not known, 3 a copy of the first"),
      F(width, "px", "image width"),
      F(height, "px", "image height"),
      F(fx, "px", "focal length along x"),
      F(fy, "px", "focal length along y"),
      F(cx, "px", "principal point, pixel centres at integers"),
      F(cy, "px", "principal point, pixel centres at integers"),
      F(k1, "", "Brown radial distortion"),
      F(k2, "", "Brown radial distortion"),
      F(p1, "", "Brown tangential distortion"),
      F(p2, "", "Brown tangential distortion"),
      F(frozen, "", "1 when the intrinsics no longer change; nothing metric is computed before"),
      F(sigma_focal_px, "px", "one-sigma error of fx: 0 given as exact, NaN unknown"),
      F(sigma_cx_px, "px", "one-sigma error of cx, likewise"),
      F(sigma_cy_px, "px", "one-sigma error of cy, likewise"),
  };
};

template <>
struct Fields<FrameRecord> {
  using R = FrameRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number of the frame in order of arrival, from 1"),
      F(time_ns, "ns", "exposure time since the mission epoch"),
      F(sequence, "", "the camera's own counter"),
      F(width, "px", "image width"),
      F(height, "px", "image height"),
      F(altitude, "m", "height above ground from ancillary data, NaN when unknown"),
      F(capture_id, "", "the capture that it answers, 0 when the camera runs freely"),
      F(time_doubt, "",
        "its time: 0 as stamped, 1 the commanded one, far from the stamp, 2 from the camera's period, far from the "
        "stamp"),
      F(name, "", "name given by the source"),
      F(image, "", "grey values, row by row; released once no product needs them"),
  };
};

template <>
struct Fields<CaptureRecord> {
  using R = CaptureRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number of the capture, from 1"),
      F(requested_ns, "ns", "when the image is wanted"),
      F(issued_ns, "ns", "when this was decided"),
      F(source, "", "0 regular, 1 forecast, 2 on the way to it, 3 safe interval, 4 telecommand"),
      F(state, "", "0 pending, 1 exposed, 2 no frame, 3 rejected, 4 superseded"),
      F(command_id, "", "the telecommand, 0 for none"),
      F(frame_id, "", "the frame that answers it, 0 for none"),
      F(exposed_ns, "ns", "exposure time of that frame"),
      F(overlap, "", "forecast overlap with the latest keyframe, NaN when unknown"),
      F(overlap_sigma, "", "its one-sigma error"),
      F(speed_px_s, "px/s", "apparent speed of the ground, NaN when unknown"),
      F(reason, "", "why it was rejected: code of the event"),
  };
};

template <>
struct Fields<OverlapRecord> {
  using R = OverlapRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "frame"),
      F(keyframe_id, "", "keyframe it was compared with, 0 for none"),
      F(verdict, "", "0 ok, 1 overlap_unknown, 2 texture_poor, 3 too_dark, 4 blurred"),
      F(decision, "", "0 skipped, 1 selected, 2 new strip, 3 rejected"),
      F(overlap, "", "share of the keyframe's area seen again"),
      F(scale, "", "similarity frame_from_keyframe: scale"),
      F(rotation_rad, "rad", "similarity: rotation"),
      F(shift_x_px, "px", "similarity: shift"),
      F(shift_y_px, "px", "similarity: shift"),
      F(ncc, "", "best correlation"),
      F(ncc_second, "", "second-best correlation"),
      F(sigma_px, "px", "one-sigma error of the shift"),
  };
};

template <>
struct Fields<StripRecord> {
  using R = StripRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number of the strip, from 1"),
      F(first_keyframe_id, "", "first keyframe"),
      F(last_keyframe_id, "", "last keyframe so far"),
      F(end, "", "0 open, 1 overlap lost, 2 overlap unknown, 3 pose lost, 4 end of flight, 5 commanded"),
  };
};

template <>
struct Fields<KeyframeRecord> {
  using R = KeyframeRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number of the keyframe, from 1"),
      F(frame_id, "", "frame it is"),
      F(strip_id, "", "strip it belongs to"),
      F(index, "", "position in the strip, from 0"),
      F(time_ns, "ns", "exposure time since the mission epoch"),
      F(overlap, "", "share of the previous keyframe's area seen again"),
      F(plane_from_previous, "",
        "homography of the ground's plane, row-major, px of the previous keyframe to px of this"),
      F(altitude, "m", "height above ground from ancillary data, NaN when unknown"),
      F(degraded, "",
        "level of reduced work that everything of it is computed at: 0 full, 1 fewer features, 2 coarser stereo too"),
  };
};

template <>
struct Fields<PoseRecord> {
  using R = PoseRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "keyframe"),
      F(strip_id, "", "strip: its frame and its scale"),
      F(state, "", "0 provisional, 1 final, 2 failed"),
      F(verdict, "", "SequenceVerdict"),
      F(scale_source, "", "0 first baseline is 1, 1 altimeter"),
      F(q_cam_from_world, "", "unit quaternion w, x, y, z"),
      F(centre, "strip unit", "camera centre in the strip's world, z up"),
      F(sigma, "strip unit",
        "one-sigma position error along the world's axes, with the strip's first camera and first baseline as gauge"),
      F(matches, "", "corner matches with the previous keyframe"),
      F(pair_inliers, "", "of the two-view estimate with the previous keyframe"),
      F(known_points, "", "matches with points of the structure, offered to the resection; 0 for the first pair"),
      F(inliers, "", "of the resection, or of the first pair"),
      F(points, "", "points of the structure seen"),
      F(rms_px, "px", "reprojection error of the window"),
      F(gric_f, "", "GRIC of the fundamental matrix, this pair"),
      F(gric_h, "", "GRIC of the homography, this pair"),
      F(parallax_px, "px", "median parallax with the previous keyframe"),
      F(sigma_rotation_rad, "rad", "one-sigma error of the pair's rotation, 0 when not known"),
      F(sigma_direction_rad, "rad", "one-sigma error of the pair's direction of translation, 0 when not known"),
      F(scale_step, "", "scale of the pair against the structure, 1 is perfect"),
      F(two_view_verdict, "", "TwoViewVerdict of the pair with the previous keyframe"),
      F(min_depth, "strip unit", "nearest points seen (2nd percentile), 0 when none"),
      F(max_depth, "strip unit", "farthest points seen (98th percentile), 0 when none"),
      F(step_covariance, "",
        "of the step from the posed keyframe before, lower triangle: rotation vector in this camera's axes (rad), "
        "place in the axes of that one (strip unit); 0 when not known"),
      F(covariance, "",
        "of the pose, lower triangle: rotation vector in the camera's axes (rad), centre (strip unit); 0 when not "
        "known"),
  };
};

template <>
struct Fields<StructureRecord> {
  using R = StructureRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "keyframe whose pose became final with these points"),
      F(strip_id, "", "strip"),
      F(count, "", "number of points"),
      F(points, "", "StructurePoint, each followed by its StructureObservations"),
  };
};

template <>
struct Fields<CalibrationRecord> {
  using R = CalibrationRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "keyframe looked at"),
      F(strip_id, "", "strip"),
      F(verdict, "",
        "0 collecting, 1 ok, 2 too few matches, 3 planar, 4 too little parallax, 5 critical motion, 6 inconsistent"),
      F(views, "", "keyframes of the set"),
      F(matches, "", "corner matches with the previous keyframe"),
      F(inliers, "", "of them, of the fundamental matrix"),
      F(gric_f, "", "GRIC of the fundamental matrix, this pair"),
      F(gric_h, "", "GRIC of the homography, over the same matches"),
      F(motion_px, "px", "median displacement of the matches"),
      F(points, "", "points of the metric reconstruction; 0 when it was not reached"),
      F(focal_px, "px", "focal length that it says, believed or not; 0 when it was not reached"),
      F(sigma_px, "px", "one-sigma error of it, spread over parts of the data included"),
      F(axes_spread_rad, "rad", "largest angle between two optical axes of the set"),
      F(noise_px, "px", "of a coordinate, from the residuals"),
      F(consistency, "", "spread of the focal lengths of parts over what their covariances allow: near 1"),
  };
};

template <>
struct Fields<CalibrationCheckRecord> {
  using R = CalibrationCheckRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "2 * strip for its first keyframes, 2 * strip + 1 for its last ones"),
      F(strip_id, "", "strip"),
      F(first_keyframe_id, "", "first keyframe looked at"),
      F(last_keyframe_id, "", "last keyframe looked at"),
      F(verdict, "", "0 agrees, 1 contradicts, 2 cannot tell"),
      F(views, "", "keyframes"),
      F(points, "", "points"),
      F(focal_px, "px", "focal length that the images say; 0 nothing"),
      F(sigma_px, "px", "one-sigma error of it"),
      F(deviation, "", "of the camera's focal length from it, relative"),
      F(noise_px, "px", "of a coordinate, from the residuals"),
      F(consistency, "", "spread of the focal lengths of parts over what their covariances allow: near 1"),
  };
};

template <>
struct Fields<DepthRecord> {
  using R = DepthRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "keyframe"),
      F(strip_id, "", "strip"),
      F(partner_id, "", "keyframe it was matched with"),
      F(verdict, "", "0 ok, 1 no partner, 2 rectification impossible, 3 too few valid"),
      F(width, "px", "width of the maps"),
      F(height, "px", "height of the maps"),
      F(offset, "1/strip unit", "inverse depth = offset + step * value"),
      F(step, "1/strip unit", "one value, uniform in disparity"),
      F(baseline, "strip unit", "distance of the two cameras"),
      F(disparity_per_inverse_depth_px, "px strip unit",
        "px of disparity per unit of inverse depth: focal length times baseline, or in polar coordinates what a point "
        "moves in the image where that is most"),
      F(epipole_x, "px", "where the partner's place appears in the image, or that opposite to it; polar only"),
      F(epipole_y, "px", "its row"),
      F(blind_radius_px, "px", "angle about the epipole times the focal length, inside which there is no depth"),
      F(pose_sigma, "",
        "one sigma of the depth, relative, by the errors of the two poses: common to the keyframe, median over its "
        "pixels; 0 when not known"),
      F(valid, "px", "pixels with a depth"),
      F(newly_seen, "px", "pixels of the mask"),
      F(median_sigma_px, "px", "median one-sigma error of the disparity"),
      F(values, "", "16-bit little-endian inverse depth values, 0 invalid"),
      F(sigma, "", "8-bit one-sigma errors in 1/64 px of disparity, 255 or more saturated"),
      F(mask, "", "newly seen pixels, run-length coded"),
  };
};

template <>
struct Fields<RichnessRecord> {
  using R = RichnessRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "keyframe"),
      F(strip_id, "", "strip"),
      F(richness, "", "Image Richness Index, 0 to 1"),
      F(gradient_fine, "", "gradient at 2 px, striking over ordinary places, squashed to 0..1"),
      F(gradient_coarse, "", "gradient at 4 px, striking over ordinary places, squashed"),
      F(entropy, "", "entropy of grey values, squashed"),
      F(contrast, "", "contrast of spots against their surroundings, squashed"),
      F(relief, "", "height range after removing the plane, squashed"),
      F(slope_steep, "", "steepest slopes, squashed"),
      F(slope_excess, "", "steepest slopes over ordinary ones, squashed"),
      F(roughness_fine, "", "roughness at the short baseline, squashed"),
      F(roughness_coarse, "", "roughness at the long baseline, squashed"),
      F(curvature, "", "strongest curvature of the ground, squashed"),
      F(novelty, "", "distance from what this flight has seen, squashed"),
      F(mask_fraction, "", "newly seen share of the image"),
      F(has_terrain, "", "1: depth was there; else the terrain cues count 0.2 each, as on plain ground"),
      F(images_learned, "", "images that the novelty was told against"),
  };
};

template <>
struct Fields<ProductRecord> {
  using R = ProductRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "4 * keyframe + kind"),
      F(keyframe_id, "", "keyframe"),
      F(strip_id, "", "strip"),
      F(kind, "", "0 depth, 1 image"),
      F(scheme, "", "0 lossy with region of interest, 1 lossless region, 2 thumbnail"),
      F(state, "", "0 stored, 1 sent, 2 acknowledged, 3 dropped"),
      F(priority, "", "order of transmission, larger first"),
      F(grant_bytes, "byte", "ceiling given by the bit plan"),
      F(bytes, "byte", "size of the JP2 file"),
      F(crc32, "", "CRC-32 of the JP2 file"),
      F(layers, "", "quality layers"),
      F(layer_bytes, "byte", "size of the file when cut after layer i, 0 beyond the layers"),
      F(layer_quality, "",
        "after layer i, of what was newly seen: image PSNR in dB (120: exact); depth largest error in px of disparity"),
      F(layers_sent, "", "the first so many have been handed to the link"),
      F(layers_held, "", "bit k is set when the ground has confirmed layer k + 1"),
      F(data, "", "the JP2 file"),
  };
};

template <>
struct Fields<DownlinkRecord> {
  using R = DownlinkRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number of the file, from 1"),
      F(kind, "", "0 product, 1 records, 2 sparse points"),
      F(subject_id, "", "product, or keyframe of the records or points; of events minus the first one, 0 without any"),
      F(bytes, "byte", "size of the file"),
      F(crc32, "", "CRC-32 of the file"),
      F(sent_ns, "ns", "when it was handed to the link"),
      F(acknowledged_ns, "ns", "when the ground confirmed it, 0 before"),
      F(records_through, "", "keyframes up to this one had been sent as records"),
      F(points_through, "", "and their sparse points"),
      F(first_layer, "", "of a product, from 1; 0 for other files"),
      F(last_layer, "", "of a product; 0 for other files"),
      F(name, "", "file name"),
  };
};

template <>
struct Fields<StorageRecord> {
  using R = StorageRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "always 1"),
      F(frame_bytes, "byte", "raw frames held"),
      F(depth_bytes, "byte", "depth maps held, with their errors and masks"),
      F(structure_bytes, "byte", "final points held"),
      F(product_bytes, "byte", "products held"),
      F(frames_held, "", "raw frames held"),
      F(depths_held, "", "depth maps held"),
      F(structures_held, "", "batches of final points held"),
      F(products_held, "", "products held"),
      F(budget_bytes, "byte", "allowed in all"),
      F(full, "", "1 from the high watermark until the low one is reached again"),
      F(times_full, "", "how often that was so"),
      F(oldest_age_ns, "ns", "how much older than the newest keyframe the oldest product held is"),
      F(frames_released, "", "raw frames that nobody needed any more"),
      F(frames_skipped, "", "raw frames given up before anybody had looked at them"),
      F(layers_cut, "", "last quality layers taken from products"),
      F(products_dropped, "", "products given up unsent"),
      F(products_damaged, "", "products given up because their bytes had changed"),
      F(products_acknowledged, "", "products deleted after confirmation"),
      F(structures_dropped, "", "batches of final points given up unsent"),
      F(files_lost, "", "files of products that went again because the ground did not confirm them"),
      F(skipped_bytes, "byte", "of frames_skipped"),
      F(cut_bytes, "byte", "of layers_cut"),
      F(dropped_bytes, "byte", "of products_dropped, products_damaged and structures_dropped"),
      F(acknowledged_bytes, "byte", "of products_acknowledged"),
      F(rows_erased, "", "records of the past that were erased"),
      F(database_bytes, "byte", "size of the database"),
      F(database_free_bytes, "byte", "of these, free for the next records"),
  };
};

template <>
struct Fields<CommandRecord> {
  using R = CommandRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number of the command, from 1"),
      F(time_ns, "ns", "when it was given"),
      F(kind, "",
        "0 end of strip, 1 capture, 2 refine, 3 capture at the time or at once, 4 delete a product, 5 restart a "
        "component"),
      F(reason, "", "why: see strip.end"),
      F(after_frame_id, "", "it applies once this frame has been looked at"),
      F(at_ns, "ns", "capture: when the image is wanted"),
      F(keyframe_id, "", "refine: the keyframe whose products are wanted before all others"),
      F(subject_id, "", "product to delete, or number of the component to restart"),
      F(request_id, "", "number of the telecommand that it comes from, 0 for none"),
      F(tag, "", "capture: the ground's own mark"),
  };
};

template <>
struct Fields<EventRecord> {
  using R = EventRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number of the event, from 1"),
      F(time_ns, "ns", "mission time"),
      F(code, "", "StatusCode"),
      F(severity, "", "0 info, 1 low, 2 medium, 3 high"),
      F(component, "", "who raised it"),
      F(a, "", "first value of the text"),
      F(b, "", "second value of the text"),
      F(place, "", "file of a failed assertion"),
  };
};

template <>
struct Fields<ComponentRecord> {
  using R = ComponentRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number in the schedule"),
      F(name, "", "component"),
      F(steps, "", "steps taken"),
      F(overruns, "", "steps over budget"),
      F(restarts, "", "restarts from the checkpoint"),
      F(faults, "", "steps that returned a fault"),
      F(busy_ns, "ns", "processor time used"),
      F(longest_ns, "ns", "longest step"),
  };
};

template <>
struct Fields<CheckpointRecord> {
  using R = CheckpointRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number in the schedule; 100 more: the other one of two"),
      F(cursor, "", "last input consumed"),
      F(cursor_second, "", "last input consumed of the second kind"),
      F(generation, "", "the larger one of two is the newer"),
      F(checksum, "", "of all other fields and the state"),
      F(layout, "", "fingerprint of the state's layout"),
      F(state, "", "the component's state"),
  };
};

template <>
struct Fields<SettingRecord> {
  using R = SettingRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number of the parameter, from 1"),
      F(name, "", "section.key"),
      F(value, "", "what it was set to, in its own unit"),
      F(set_ns, "ns", "when"),
  };
};

template <>
struct Fields<ScheduledRecord> {
  using R = ScheduledRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number of the request, from 1"),
      F(release_ns, "ns", "when it is carried out"),
      F(source, "", "source ID of the request"),
      F(apid, "", "its application process"),
      F(count, "", "its sequence count"),
      F(sub_schedule, "", "where the tailoring has sub-schedules"),
      F(group, "", "where the tailoring has groups"),
      F(ahead, "", "1 a capture, which the camera is told before its time"),
      F(packet, "", "the telecommand"),
  };
};

template <>
struct Fields<CommandingRecord> {
  using R = CommandingRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "1"),
      F(received, "", "packets for telecommands, scheduled ones at their release included"),
      F(accepted, "", "of them accepted"),
      F(rejected, "", "not accepted, and answered"),
      F(unanswerable, "", "not accepted, and nobody to answer"),
      F(completed, "", "carried out"),
      F(failed, "", "accepted, but not carried out"),
      F(open, "", "waiting for their completion"),
      F(scheduled, "", "waiting for their time"),
      F(schedule_enabled, "", "1: requests are released when their time comes"),
      F(reports_sent, "", "packets of telemetry since the last start"),
      F(reports_lost, "", "that did not fit while nobody listened"),
      F(reports_waiting, "", "that wait for contact"),
  };
};

template <>
struct Fields<TransferRecord> {
  using R = TransferRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number of the transfer; they grow"),
      F(name, "", "file name"),
      F(state, "", "0 waiting, 1 sending, 2 sent once and being completed, 3 delivered"),
      F(wish, "", "of the ground: 0 none, 1 suspend, 2 resume, 3 cancel"),
      F(suspended, "", "1 while it is suspended"),
      F(priority, "", "0 goes first"),
      F(bytes, "byte", "size of the file"),
      F(crc32, "", "CRC-32 of the file"),
      F(checksum_type, "", "of CFDP: 0 modular, 2 CRC-32C, 3 CRC-32, 15 none"),
      F(checksum, "", "of that type"),
      F(sequence, "", "transaction sequence number; 0 before the first"),
      F(destination, "", "entity that it goes to"),
      F(progress, "byte", "at least so many have gone once"),
      F(resent_bytes, "byte", "sent again because the ground asked"),
      F(attempts, "", "transactions that the ground ended without holding the file"),
      F(condition, "", "condition code of the latest of them"),
      F(queued_ns, "ns", "when it was handed over"),
      F(delivered_ns, "ns", "when the ground said that it holds the file"),
      F(data, "byte", "the file, until it is delivered"),
      F(gaps, "byte", "what the ground has asked for: pairs of u32, begin and end"),
  };
};

template <>
struct Fields<UplinkRecord> {
  using R = UplinkRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number of the file, from 1"),
      F(name, "", "file name"),
      F(state, "", "0 checked, 1 rejected, 2 active, 3 was active"),
      F(fault, "", "code of the event that says why it was rejected"),
      F(fault_place, "", "line of the file, or number of the parameter"),
      F(source, "", "entity that it came from"),
      F(sequence, "", "transaction sequence number"),
      F(crc32, "", "CRC-32 of the file"),
      F(received_ns, "ns", "when it was whole"),
      F(activated_ns, "ns", "when it was made active, 0 before"),
      F(data, "byte", "the file"),
  };
};

template <>
struct Fields<StartRecord> {
  using R = StartRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "number of the start, from 1"),
      F(time_ns, "ns", "mission time of the start"),
      F(alive_ns, "ns", "when this life was last written down"),
      F(end_ns, "ns", "when it ended in order, 0: it did not"),
      F(reason, "",
        "0 first start, 1 after an ordered stop, 2 the process died, 3 the board was reset, 4 its watchdog had bitten"),
      F(tested, "", "bit k: self-test k was run (docs/onboard.md)"),
      F(failed, "", "bit k: self-test k failed"),
      F(stack_bytes, "byte", "deepest use of the flight's stack"),
      F(heap_traps, "", "requests for memory after start-up, refused"),
      F(unconfirmed, "", "starts in a row before this one that no telecommand confirmed"),
      F(configuration, "", "began with 0 what was set, 1 the last good configuration, 2 built-in defaults"),
      F(version, "", "of the software"),
      F(board, "", "the board's own name for its boot"),
  };
};

template <>
struct Fields<TimingRecord> {
  using R = TimingRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "always 1"),
      F(frames, "", "minor frames since the last start"),
      F(overruns, "", "minor frames that ended too late"),
      F(longest_ns, "ns", "longest minor frame"),
      F(latest_ns, "ns", "latest begin of a minor frame behind its time"),
      F(late, "", "begins behind their time: bin 0 below 1 us, bin k in [2^(k-1), 2^k) us"),
      F(used, "", "lengths of minor frames, in the same bins"),
      F(degraded, "", "level of reduced work, 0 none"),
      F(degraded_changes, "", "changes of the level"),
  };
};

template <>
struct Fields<IdentityRecord> {
  using R = IdentityRecord;
  static constexpr FieldInfo table[] = {
      F(id, "", "always 1"),
      F(life, "", "number of the life, from 1: another one with every new store"),
      F(keyframe_base, "", "keyframes, strips and event files count from the number behind it"),
      F(record_base, "", "all other records likewise"),
      F(configuration, "", "grows with every change of the settings"),
  };
};

#undef F

template <typename Record>
constexpr RecordInfo describe(RecordType type, const char* name, const char* description) {
  static_assert(std::is_trivially_copyable_v<Record> && std::is_standard_layout_v<Record>);
  static_assert(sizeof(Record) <= limits::max_record_bytes);
  static_assert(std::size(Fields<Record>::table) <= limits::max_record_fields);
  return {type,
          name,
          description,
          static_cast<std::uint16_t>(sizeof(Record)),
          static_cast<std::uint16_t>(std::size(Fields<Record>::table)),
          Fields<Record>::table};
}

constexpr RecordInfo infos[] = {
    describe<CameraRecord>(RecordType::camera, "camera", "the camera's intrinsics"),
    describe<FrameRecord>(RecordType::frame, "frame", "images as the camera gave them"),
    describe<CaptureRecord>(RecordType::capture, "capture", "times at which images are wanted"),
    describe<OverlapRecord>(RecordType::overlap, "overlap", "overlap of each frame with the latest keyframe"),
    describe<StripRecord>(RecordType::strip, "strip", "runs of keyframes with one origin and scale"),
    describe<KeyframeRecord>(RecordType::keyframe, "keyframe", "frames selected for processing"),
    describe<CalibrationRecord>(RecordType::calibration, "calibration", "what self-calibration said at a keyframe"),
    describe<PoseRecord>(RecordType::pose, "pose", "where keyframes were taken"),
    describe<StructureRecord>(RecordType::structure, "structure", "final points of the structure"),
    describe<CalibrationCheckRecord>(RecordType::calibration_check, "calibration_check",
                                     "whether a strip agrees with the camera's focal length"),
    describe<DepthRecord>(RecordType::depth, "depth", "inverse depth, error and mask of keyframes"),
    describe<RichnessRecord>(RecordType::richness, "richness", "Image Richness Index and its cues"),
    describe<ProductRecord>(RecordType::product, "product", "coded images and depth maps"),
    describe<DownlinkRecord>(RecordType::downlink, "downlink", "files handed to the link"),
    describe<StorageRecord>(RecordType::storage, "storage", "accounting of the storage manager"),
    describe<CommandRecord>(RecordType::command, "command", "commands to the components"),
    describe<EventRecord>(RecordType::event, "event", "event reports"),
    describe<ComponentRecord>(RecordType::component, "component", "health and time of the components"),
    describe<CheckpointRecord>(RecordType::checkpoint, "checkpoint", "where components continue after a restart"),
    describe<TransferRecord>(RecordType::transfer, "transfer", "files on their way to the ground by CFDP"),
    describe<UplinkRecord>(RecordType::uplink, "uplink", "files that have come from the ground"),
    describe<SettingRecord>(RecordType::setting, "setting", "mission parameters set by telecommand"),
    describe<ScheduledRecord>(RecordType::scheduled, "scheduled", "telecommands that wait for their time"),
    describe<CommandingRecord>(RecordType::commanding, "commanding", "what became of telecommands and reports"),
    describe<StartRecord>(RecordType::start, "start", "lives of the software, and why each began"),
    describe<TimingRecord>(RecordType::timing, "timing", "how minor frames keep their time"),
    describe<IdentityRecord>(RecordType::identity, "identity", "which life of the flight this is"),
};
static_assert(std::size(infos) == static_cast<std::size_t>(RecordType::count));
static_assert(std::size(infos) <= limits::max_record_types && std::size(infos) <= 32, "a RecordMask has 32 bits");
constexpr bool in_order() {
  for (std::size_t i = 0; i < std::size(infos); ++i) {
    if (infos[i].type != static_cast<RecordType>(i) || infos[i].fields[0].offset != 0) return false;
  }
  return true;
}
static_assert(in_order());

}  // namespace

const RecordInfo& record_info(RecordType type) {
  return infos[static_cast<std::size_t>(type)];
}

#define ILP_RECORD_INFO(Record, type)                         \
  template <>                                                 \
  const RecordInfo& record_info<Record>() {                   \
    return infos[static_cast<std::size_t>(RecordType::type)]; \
  }
ILP_RECORDS(ILP_RECORD_INFO)
#undef ILP_RECORD_INFO

CameraModel camera_model(const CameraRecord& r) {
  return {r.width, r.height, r.fx, r.fy, r.cx, r.cy, r.k1, r.k2, r.p1, r.p2};
}

CameraRecord camera_record(const CameraModel& c) {
  return {camera_id, c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, 1, 0, 0, 0};
}

CameraRecord nominal_camera_record(const CameraModel& camera) {
  CameraRecord record = camera_record(camera);
  record.frozen = 0;
  record.sigma_focal_px = record.sigma_cx_px = record.sigma_cy_px = unknown;
  return record;
}

Pose pose_of(const PoseRecord& record) {
  Pose pose;
  for (int i = 0; i < 4; ++i) pose.q_cam_from_world[i] = record.q_cam_from_world[i];
  for (int i = 0; i < 3; ++i) pose.centre[i] = record.centre[i];
  return pose;
}

}  // namespace ilp
