#include "fsw/shared/image_cache.hpp"

#include <algorithm>

#include "fsw/base/memory_sum.hpp"
#include "fsw/records/records.hpp"

namespace ilp {
namespace {

/// Frames have one blob.
bool is_image(const RecordInfo& info, std::size_t offset, std::size_t bytes) {
  return info.type == RecordType::frame && offset == 0 && bytes != 0 && bytes <= limits::max_image_pixels;
}

}  // namespace

void ImageCache::Image::hold(std::int64_t id, std::span<const std::uint8_t> image) {
  frame_id = id;
  bytes = image.size();
  std::copy(image.begin(), image.end(), pixels.begin());
  checksum = sum();
}

std::uint64_t ImageCache::Image::sum() const {
  const std::int64_t head[] = {frame_id, static_cast<std::int64_t>(bytes)};
  return memory_sum64(std::as_bytes(std::span(pixels).first(bytes)), checksum64(memory_of(head)));
}

ImageCache::Image* ImageCache::find(std::int64_t id, std::size_t bytes) {
  const auto is_meant = [&](const Image& image) { return image.frame_id == id && image.bytes == bytes; };
  Image* found = is_meant(newest_) && uncommitted_id_ != id ? &newest_ : nullptr;
  for (Image& image : read_) {
    if (is_meant(image)) found = &image;
  }
  if (found == nullptr) return nullptr;
  if (found->checksum == found->sum()) return found;
  found->frame_id = 0;
  return nullptr;
}

void ImageCache::forget(std::int64_t id) {
  if (newest_.frame_id == id) newest_.frame_id = 0;
  for (Image& image : read_) {
    if (image.frame_id == id) image.frame_id = 0;
  }
}

Status ImageCache::commit() {
  const Status status = inner_.commit();
  if (!status.ok()) forget(uncommitted_id_);
  uncommitted_id_ = 0;
  return status;
}

void ImageCache::rollback() {
  inner_.rollback();
  forget(uncommitted_id_);
  uncommitted_id_ = 0;
}

/// Afterwards the image may have another size, or be released.
Status ImageCache::put(const RecordInfo& info, const void* record) {
  if (info.type == RecordType::frame) forget(static_cast<const FrameRecord*>(record)->id);
  return inner_.put(info, record);
}

Status ImageCache::erase(const RecordInfo& info, std::int64_t id) {
  if (info.type == RecordType::frame) forget(id);
  return inner_.erase(info, id);
}

Status ImageCache::write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                              std::span<const std::uint8_t> bytes) {
  if (info.type == RecordType::frame) forget(id);
  const Status status = inner_.write_blob(info, field, id, offset, bytes);
  if (status.ok() && is_image(info, offset, bytes.size())) {
    newest_.hold(id, bytes);
    uncommitted_id_ = id;
  }
  return status;
}

Status ImageCache::read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                             std::span<std::uint8_t> bytes) {
  if (!is_image(info, offset, bytes.size())) return inner_.read_blob(info, field, id, offset, bytes);
  if (Image* known = find(id, bytes.size())) {
    known->used = ++uses_;
    std::copy_n(known->pixels.begin(), bytes.size(), bytes.begin());
    return {};
  }
  const Status status = inner_.read_blob(info, field, id, offset, bytes);
  if (status.ok() && uncommitted_id_ != id) {
    Image& oldest =
        *std::min_element(read_.begin(), read_.end(), [](const Image& a, const Image& b) { return a.used < b.used; });
    oldest.hold(id, bytes);
    oldest.used = ++uses_;
  }
  return status;
}

}  // namespace ilp
