// The link to which Downlink writes files when they travel by CFDP. Each file becomes a record `transfer`, which the
// component FileDelivery delivers to the ground (docs/file-delivery.md).
#pragma once

#include <array>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "fsw/base/checksum.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/downlink/downlink_buffers.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/link.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Counts for housekeeping.
struct DeliveryCounts {
  std::uint32_t pdus_in = 0, pdus_out = 0;
  std::uint32_t rejected = 0;   ///< malformed PDUs
  std::uint32_t ignored = 0;    ///< PDUs for another entity, or of an unknown transaction
  std::uint32_t delivered = 0;  ///< files that the ground holds
  std::uint32_t refused = 0;    ///< transactions that the ground ended without the file
  std::uint32_t cancelled = 0;
  std::uint32_t events_lost = 0;
};
/// What FileDelivery has left to send of the transfers that it knows. It counts this again in every step.
struct DeliveryBacklog {
  std::int64_t known_through = 0;  ///< newest transfer that is counted
  std::int64_t bytes = 0;          ///< without transfers that are suspended, rest or wait after a fault
};
/// What FileDelivery states of its work, for others to read.
struct DeliveryFigures {
  DeliveryCounts counts;
  DeliveryBacklog backlog;
};

/// Everything is written within the transaction that the caller has opened. A file is therefore queued exactly when the
/// caller has committed that it has sent it.
class DeliveryQueue final : public Link {
 public:
  using Tables = StorePart<Writes<TransferRecord>, Erases<TransferRecord>>;
  using Scratch = StepScratch<DownlinkBuffers>;

  /// A file lies in the memory of the downlink's step, in which it is begun and ended. The transfers that FileDelivery
  /// knows are counted by its `backlog`, because their records state their progress only roughly.
  DeliveryQueue(Tables store, Clock& clock, const MissionParameters& mission, Scratch scratch,
                const DeliveryBacklog* backlog = nullptr);

  /// `transfer_queue_full` when limits::max_transfers files or cfdp_queue_kib of them are queued: try again later.
  Status begin_file(const char* name) override;
  /// `capacity_exceeded` beyond limits::max_transfer_bytes: the file is abandoned.
  Status write(std::span<const std::uint8_t> bytes) override;
  /// Replaces a queued file of the same name.
  Status end_file() override;
  /// Size and CRC of a file that the ground has received completely and checked, `not_ready` before. After a committed
  /// transaction with this answer the transfer is over, and it is not given again.
  Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) override;
  /// The backlog, and the files that it does not count yet.
  Status unsent(std::int64_t& bytes) override;

  /// The bytes that never change.
  [[nodiscard]] std::span<const std::byte> constants() const { return memory_between(this, &entries_); }

 private:
  struct Entry {
    std::int64_t id;
    char name[32];
  };

  /// Counts the transfers and the bytes of their files. Damaged records are erased, and at most one more to make room.
  Status survey(std::uint64_t& bytes);
  Status erase_others_of(const char* name);

  Tables store_;
  Clock& clock_;
  const MissionParameters& mission_;
  Scratch scratch_;
  const DeliveryBacklog* backlog_;
  FixedVector<Entry, limits::max_transfers> entries_;
  bool surveyed_ = false;
  std::int64_t last_id_ = 0;  ///< ids of erased records are not used again while the software runs
  bool open_ = false;
  char name_[32] = {};
  std::size_t bytes_ = 0;
};

/// Sets the ground's request for the transfer with this transaction sequence number (of a longer number its last four
/// octets), or for all transfers (0). Call it within a transaction. `not_found` when there is none.
Status request_transfer(StorePart<Changes<TransferRecord>> store, std::int64_t sequence, TransferWish wish);

}  // namespace ilp
