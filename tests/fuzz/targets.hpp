// The fuzz targets: each takes any octets and throws when the software does something that it must not do.
// The sanitizers find the rest.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

namespace ilp::fuzz {

using Octets = std::span<const std::uint8_t>;

/// Telecommands, bodies of all services in all tailorings, time codes: total, and encoding says the same again.
void telecommand(Octets input);
/// CFDP PDUs: total, and encoding says the same again.
void cfdp_pdu(Octets input);
/// One transaction of each side: whatever comes, only PDUs within the file are sent, and then no more.
void cfdp_sender(Octets input);
void cfdp_receiver(Octets input);
/// Packets, PDUs, time, restarts and outages for Telecommander, FileDelivery and TelemetryReporter on one store.
void session(Octets input);
/// Places, ties and poses on record that hold anything, and a flight that comes back to their ground.
void place_memory(Octets input);

/// Directories and tiles of maps, with right checksums.
void map_files(Octets input);

/// JPEG files as a camera's pictures, of the size that they state; raw pictures of any format, size and row length.
void camera_jpeg(Octets input);
void camera_picture(Octets input);

/// What the ground reads (tests/fuzz/ground). PDUs for its ends of file delivery.
void ground_cfdp(Octets input);
/// Files of an outbox with any names; the same with records that are changed at any place and have good checksums.
void ground_outbox(Octets input);
void ground_records(Octets input);
/// The metadata of a product; a whole product, decoded.
void ground_metadata(Octets input);
void ground_product(Octets input);
/// Packets and reports, as the operator's console shows them.
void ground_telemetry(Octets input);
/// A catalogue whose rows hold anything; one whose file is changed at any place; the whole run of the ground over
/// changed files.
void ground_catalogue(Octets input);
void ground_catalogue_file(Octets input);
void ground_run(Octets input);
/// Links and ties that are changed at any place, joined into one model.
void ground_links(Octets input);

struct Target {
  const char* name;  ///< of its corpus too
  void (*run)(Octets input);
  int mutations = 10'000;  ///< that are replayed in every build
};
inline constexpr Target targets[] = {{"telecommand", telecommand},
                                     {"cfdp_pdu", cfdp_pdu},
                                     {"cfdp_sender", cfdp_sender},
                                     {"cfdp_receiver", cfdp_receiver},
                                     {"session", session},
                                     {"ground_cfdp", ground_cfdp},
                                     {"ground_outbox", ground_outbox, 3'000},
                                     {"ground_records", ground_records, 3'000},
                                     {"ground_metadata", ground_metadata},
                                     {"ground_product", ground_product, 1'000},
                                     {"ground_telemetry", ground_telemetry},
                                     {"ground_catalogue", ground_catalogue, 1'000},
                                     {"ground_catalogue_file", ground_catalogue_file, 200},
                                     {"ground_run", ground_run, 10},
                                     {"place_memory", place_memory, 100},
                                     {"ground_links", ground_links, 100},
                                     {"camera_jpeg", camera_jpeg},
                                     {"camera_picture", camera_picture},
                                     {"map_files", map_files, 2'000}};

inline void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);
}

/// Reads choices from the input; at its end everything is 0.
class Choices {
 public:
  explicit Choices(Octets input) : input_(input) {}
  [[nodiscard]] bool empty() const { return input_.empty(); }
  std::uint64_t number(std::size_t octets) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < octets; ++i) value = (value << 8U) | byte();
    return value;
  }
  std::uint8_t byte() {
    if (input_.empty()) return 0;
    const std::uint8_t value = input_.front();
    input_ = input_.subspan(1);
    return value;
  }
  std::uint32_t u16() { return static_cast<std::uint32_t>(number(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  /// As many octets as the first octet says, or all that are left.
  Octets bytes() { return take(byte()); }
  Octets take(std::size_t most) {
    const Octets part = input_.first(most < input_.size() ? most : input_.size());
    input_ = input_.subspan(part.size());
    return part;
  }
  Octets rest() { return take(input_.size()); }

 private:
  Octets input_;
};

}  // namespace ilp::fuzz
