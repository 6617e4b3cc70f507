// The links of a flight that several processes share. They send nothing that follows from a commit which a power cut
// could still undo.
#pragma once

#include "bsp/flight/shared_flight_store.hpp"
#include "hal/link/link.hpp"
#include "hal/link/packet_link.hpp"

namespace ilp {

/// Sends files. end_file() waits until all that this process has read from the store is on the disk, and returns
/// `not_ready` if that fails.
class CommittedLink final : public Link {
 public:
  CommittedLink(Link& link, SharedFlightStore& store, StoreSharing& sharing)
      : link_(link), store_(store), sharing_(sharing) {}

  /// Waits for the disk before the transaction, so that the other processes need not wait during it. If that fails,
  /// end_file() returns `not_ready`.
  void prepare() override {
    static_cast<void>(sharing_.flush_own());
    link_.prepare();
  }
  Status begin_file(const char* name) override { return link_.begin_file(name); }
  Status write(std::span<const std::uint8_t> bytes) override { return link_.write(bytes); }
  Status end_file() override { return store_.commit_read(sharing_).ok() ? link_.end_file() : StatusCode::not_ready; }
  Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) override {
    return link_.acknowledged(name, bytes, crc32);
  }
  Status unsent(std::int64_t& bytes) override { return link_.unsent(bytes); }

 private:
  Link& link_;
  SharedFlightStore& store_;
  StoreSharing& sharing_;
};

/// Sends packets: send() waits for the disk as CommittedLink::end_file().
class CommittedPacketLink final : public PacketLink {
 public:
  /// `link` may be the null pointer. Only if_present() may be called then.
  CommittedPacketLink(PacketLink* link, SharedFlightStore& store, StoreSharing& sharing)
      : link_(link), store_(store), sharing_(sharing) {}

  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override { return link_->receive(buffer, bytes); }
  Status send(std::span<const std::uint8_t> packet) override {
    return store_.commit_read(sharing_).ok() ? link_->send(packet) : StatusCode::not_ready;
  }
  void accept_sender() override { link_->accept_sender(); }
  /// Returns this link, or the null pointer if it was made without a link.
  [[nodiscard]] PacketLink* if_present() { return link_ != nullptr ? this : nullptr; }

 private:
  PacketLink* link_;
  SharedFlightStore& store_;
  StoreSharing& sharing_;
};

}  // namespace ilp
