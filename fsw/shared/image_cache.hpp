// Images of frames that were written or read lately, in front of the store.
#pragma once

#include <array>
#include <cstring>

#include "cfg/limits.hpp"
#include "fsw/base/checksum.hpp"
#include "hal/store/forwarding_store.hpp"

namespace ilp {

/// Answers a reading of a frame's whole image from memory where the image was read or committed lately. Every other
/// call goes to the store behind. All components that write, change or erase frames have to use the same cache.
///
/// The newest committed image has a place of its own: frames that nobody looks at again do not push out the keyframes
/// at work. An image in memory has a checksum, which every use compares. Where it has changed the image is forgotten
/// and read from the store. What is damaged in the store itself is answered as the store does, unless it is still at
/// hand.
class ImageCache final : public ForwardingStore {
 public:
  using ForwardingStore::ForwardingStore;

  Status commit() override;
  void rollback() override;
  Status put(const RecordInfo& info, const void* record) override;
  Status erase(const RecordInfo& info, std::int64_t id) override;
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override;
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override;

 private:
  struct Image {
    std::int64_t frame_id = 0;  ///< 0: none
    std::size_t bytes = 0;
    std::int64_t used = 0;  ///< larger: later
    std::uint64_t checksum = 0;
    std::array<std::uint8_t, limits::max_image_pixels> pixels;

    void hold(std::int64_t id, std::span<const std::uint8_t> image);
    [[nodiscard]] std::uint64_t sum() const;
  };

  [[nodiscard]] Image* find(std::int64_t id, std::size_t bytes);
  void forget(std::int64_t id);

  Image newest_;                     ///< that was written last
  std::int64_t uncommitted_id_ = 0;  ///< written in the open transaction
  std::array<Image, limits::cached_images> read_;
  std::int64_t uses_ = 0;
};

}  // namespace ilp
