#include "fsw/shared/frame_access.hpp"

#include "fsw/shared/camera_on_record.hpp"

namespace ilp {

Status load_frame_image(Reader<FrameRecord> store, std::int64_t frame_id, FrameImage& image) {
  FrameRecord frame;
  ILP_TRY(get(store, frame_id, frame));
  ILP_TRY(image.resize(frame.width, frame.height));
  const ImageView<std::uint8_t> view = image.view();
  if (frame.image.bytes != view.area()) return {StatusCode::not_found, frame_id};
  return read_blob<FrameRecord>(store, "image", frame_id, 0, {view.data, view.area()});
}

Status load_keyframe_image(Reader<KeyframeRecord, FrameRecord> store, std::int64_t keyframe_id, FrameImage& image) {
  KeyframeRecord keyframe;
  ILP_TRY(get(store, keyframe_id, keyframe));
  return load_frame_image(store, keyframe.frame_id, image);
}

Status load_camera(Reader<CameraRecord> store, CameraModel& camera) {
  CameraRecord record;
  ILP_TRY(get_camera(store, camera_id, record));
  camera = camera_model(record);
  return {};
}

}  // namespace ilp
