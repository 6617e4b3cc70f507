// A cache of recently written or read images between the components and the store.
#pragma once

#include <array>
#include <cstring>

#include "cfg/limits.hpp"
#include "fsw/base/checksum.hpp"
#include "hal/store/forwarding_store.hpp"

namespace ilp {

/// Serves reads of a frame's complete image from memory if the image was read or committed recently. Every other call
/// goes to the store. All components that write, change or erase frames must use the same cache.
///
/// The newest committed image has a slot of its own, so that frames that nobody reads do not displace keyframes that
/// are in use. Each image in memory has a checksum, which is compared at every use; an image that has changed is
/// dropped and read from the store. A damaged image in the store is noticed only when it is not in the cache.
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
    std::int64_t used = 0;  ///< value of uses_ at the latest use
    std::uint64_t checksum = 0;
    std::array<std::uint8_t, limits::max_image_pixels> pixels;

    void hold(std::int64_t id, std::span<const std::uint8_t> image);
    [[nodiscard]] std::uint64_t sum() const;
  };

  [[nodiscard]] Image* find(std::int64_t id, std::size_t bytes);
  void forget(std::int64_t id);

  Image newest_;                     ///< the image that was written last
  std::int64_t uncommitted_id_ = 0;  ///< frame whose image was written in the open transaction; 0: none
  std::array<Image, limits::cached_images> read_;
  std::int64_t uses_ = 0;
};

}  // namespace ilp
