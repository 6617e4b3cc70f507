// Space packets back to back over TCP: listens, and talks with a bounded number of clients.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/packet_link.hpp"
#include "hal/posix/socket.hpp"

namespace ilp {

struct TcpCounts {
  std::uint32_t accepted = 0;
  std::uint32_t gave_way = 0;  ///< closed: silent for longest when a new client came
  std::uint32_t garbage = 0;   ///< closed: what came is no sequence of space packets, or broke off within one
  std::uint32_t unread = 0;    ///< closed: took nothing for too long
  std::uint32_t skipped = 0;   ///< packets that a slow client missed, whole ones, while others got them
};

/// Telemetry goes to every client. What a client sends is cut by the length field of the primary header; a packet that
/// does not come to its end within patience_ns, or a header of another version behind which no other one follows, means
/// that the boundaries are lost: the connection is closed. A packet is queued for a client whole or not at all, so that
/// a stream never holds half of one; a client that takes nothing for patience_ns is closed.
/// A new client always gets a place. When all are taken, the one gives way that has ended sending, else the one whose
/// last accepted packet (accept_sender) is longest ago; those that never sent one go before those that did.
/// A packet counts as sent when a client has queued it that has sent an accepted packet; while there is no such client,
/// when any client has.
class TcpLink final : public PacketLink {
 public:
  static constexpr TimeNs patience_ns = 5 * ns_per_s;

  explicit TcpLink(Clock& clock) : clock_(clock) {}
  ~TcpLink();

  /// `io_error` when the address is not ours or taken.
  Status open(const SocketAddress& local);
  Status address(SocketAddress& local) const { return local_address(socket_, local); }

  /// Takes new clients in and goes on with what is being sent, too: to be called in every minor frame.
  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override;
  Status send(std::span<const std::uint8_t> packet) override;
  void accept_sender() override;

  [[nodiscard]] std::size_t clients() const;
  [[nodiscard]] const TcpCounts& counts() const { return counts_; }

 private:
  struct Client {
    int socket = -1;
    std::uint32_t malformed = 0;  ///< in a row
    bool ended = false;           ///< sends no more, but may still listen; gives its place to a new one
    bool accepted = false;        ///< has sent a packet that made sense
    bool read = false;            ///< was asked for packets at least once, before which it does not give way
    std::uint64_t heard = 0;      ///< order of last accepted packets, or of coming
    TimeNs whole_ns = 0;          ///< when the last whole packet had come, or nothing waited
    TimeNs taken_ns = 0;          ///< when it last took something
    std::size_t in_first = 0, in_size = 0;
    std::size_t out_first = 0, out_size = 0;
    std::array<std::uint8_t, limits::max_packet_bytes> in;
    std::array<std::uint8_t, limits::tcp_queue_bytes> out;
  };

  void accept_client(TimeNs now);
  [[nodiscard]] Client* place_for_new();
  void admit(int socket, TimeNs now, Client& place);
  void read(Client& client, TimeNs now);
  bool next_packet(Client& client, TimeNs now, std::span<const std::uint8_t>& packet);
  void flush(Client& client, TimeNs now);
  [[nodiscard]] static bool has_room(const Client& client, std::span<const std::uint8_t> packet);
  static void enqueue(Client& client, std::span<const std::uint8_t> packet);
  void drop(Client& client, std::uint32_t& reason);

  Clock& clock_;
  int socket_ = -1;
  std::size_t next_client_ = 0;
  std::size_t sender_ = 0;  ///< of the packet that was received last
  std::uint64_t order_ = 0;
  TcpCounts counts_;
  std::array<Client, limits::max_tcp_clients> clients_{};
};

}  // namespace ilp
