// The links of a flight that several processes share: nothing is sent to the ground that a power cut could still undo.
#pragma once

#include "bsp/flight/shared_flight_store.hpp"
#include "hal/link/link.hpp"
#include "hal/link/packet_link.hpp"

namespace ilp {

/// A file becomes visible to the ground when what was read for it is on the disk; until then the link is out of contact
/// (`not_ready`).
class CommittedLink final : public Link {
 public:
  CommittedLink(Link& link, SharedFlightStore& store, StoreSharing& sharing)
      : link_(link), store_(store), sharing_(sharing) {}

  /// The other processes do not wait for the disk in the transaction. If this fails, end_file() says so.
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

/// The same for packets.
class CommittedPacketLink final : public PacketLink {
 public:
  /// Without `link` it is not used.
  CommittedPacketLink(PacketLink* link, SharedFlightStore& store, StoreSharing& sharing)
      : link_(link), store_(store), sharing_(sharing) {}

  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override { return link_->receive(buffer, bytes); }
  Status send(std::span<const std::uint8_t> packet) override {
    return store_.commit_read(sharing_).ok() ? link_->send(packet) : StatusCode::not_ready;
  }
  void accept_sender() override { link_->accept_sender(); }
  /// Returns the null pointer if there is none.
  [[nodiscard]] PacketLink* if_present() { return link_ != nullptr ? this : nullptr; }

 private:
  PacketLink* link_;
  SharedFlightStore& store_;
  StoreSharing& sharing_;
};

}  // namespace ilp
