#include "fsw/shared/frame_access.hpp"

#include <algorithm>

#include "fsw/shared/camera_on_record.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/vision/geometry/rolling_shutter.hpp"

namespace ilp {

Status load_frame_image(Reader<FrameRecord> store, std::int64_t frame_id, FrameImage& image) {
  FrameRecord frame;
  ILP_TRY(get(store, frame_id, frame));
  ILP_TRY(image.resize(frame.width, frame.height));
  const ImageView<std::uint8_t> view = image.view();
  if (frame.image.bytes != view.area()) return {StatusCode::not_found, frame_id};
  return read_blob<FrameRecord>(store, "image", frame_id, 0, {view.data, view.area()});
}

Status load_keyframe_image(Reader<KeyframeRecord, FrameRecord, CameraRecord, ShutterRecord> store,
                           std::int64_t keyframe_id, FrameImage& image) {
  KeyframeRecord keyframe;
  ILP_TRY(get(store, keyframe_id, keyframe));
  ILP_TRY(load_frame_image(store, keyframe.frame_id, image));
  ShutterRecord shutter;
  ILP_TAKE(const bool known, find<ShutterRecord>(store, keyframe_id, shutter));
  if (!known) return {};
  CameraModel camera;
  ILP_TRY(load_camera(store, camera));
  return bring_to_middle_row(camera, shutter, image).status();
}

Status load_camera(Reader<CameraRecord> store, CameraModel& camera) {
  CameraRecord record;
  ILP_TRY(get_camera(store, camera_id, record));
  camera = camera_model(record);
  return {};
}

Result<bool> bring_to_middle_row(const CameraModel& camera, const ShutterRecord& shutter, FrameImage& image) {
  if (shutter.source == MotionSource::none) return false;
  ImageMotion motion;
  std::copy_n(shutter.motion, 8, motion.m);
  return to_middle_row(camera, motion, image.width(), image.height(), image.storage());
}

}  // namespace ilp
