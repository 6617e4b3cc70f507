#include "fsw/shared/camera_on_record.hpp"

#include "fsw/shared/find.hpp"

namespace ilp {

Status get_camera(Reader<CameraRecord> store, std::int64_t id, CameraRecord& camera) {
  const Status found = get(store, id, camera);
  if (id != camera_id || !found.is(StatusCode::record_damaged)) return found;
  CameraRecord copy;
  ILP_TAKE(const bool kept, find(store, camera_copy_id, copy));
  if (!kept) return found;
  camera = copy;
  camera.id = camera_id;
  return {};
}

Status get_first_camera(Reader<CameraRecord> store, CameraRecord& camera) {
  const Status nominal = get_camera(store, nominal_camera_id, camera);
  return nominal.is(StatusCode::not_found) ? get_camera(store, camera_id, camera) : nominal;
}

Status put_camera(StorePart<Writes<CameraRecord>> store, const CameraRecord& camera) {
  CameraRecord record = camera;
  record.id = camera_copy_id;
  ILP_TRY(put(store, record));
  record.id = camera_id;
  return put(store, record);
}

}  // namespace ilp
