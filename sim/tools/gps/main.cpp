// ilp-gps: sends positions of gpsd to the flight software, in the packets of the vehicle's computer.
#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <iostream>
#include <thread>
#include <vector>

#include "fsw/navigation/vehicle_packets.hpp"
#include "hal/clock/real_clock.hpp"
#include "hal/link/udp/udp_link.hpp"
#include "sim/host/command_line.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/version_line.hpp"
#include "sim/tools/gps/gps_sample.hpp"

namespace {

using namespace ilp;

volatile std::sig_atomic_t ended = 0;

struct Options {
  std::string host = "127.0.0.1", port = "2947", to;
  std::uint16_t apid = MissionParameters{}.vehicle_apid;
};

SocketAddress address_of(const std::string& text) {
  SocketAddress address;
  if (!parse_address(text.c_str(), address).ok()) {
    throw std::runtime_error(text + ": an address is four numbers and a port, such as 127.0.0.1:9000");
  }
  return address;
}

class Receiver {
 public:
  explicit Receiver(const Options& options) : host_(options.host), port_(options.port) {}
  ~Receiver() { close(); }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  /// The next position; false when none has come for a while. Without a connection it tries to get one.
  bool next(NavigationSample& sample, UtcNs& utc) {
    if (!open_ && !connect()) {
      std::this_thread::sleep_for(std::chrono::seconds(1));
      return false;
    }
    if (!gps_waiting(&data_, 500000)) return false;
    if (gps_read(&data_, nullptr, 0) < 0) {
      std::cerr << "ilp-gps: gpsd has ended the connection\n";
      close();
      return false;
    }
    return (data_.set & TIME_SET) != 0 && gps::sample_of(data_.fix, sample, utc);
  }

 private:
  bool connect() {
    if (gps_open(host_.c_str(), port_.c_str(), &data_) != 0) {
      if (!reported_)
        std::cerr << "ilp-gps: gpsd at " << host_ << ":" << port_ << ": " << gps_errstr(errno) << "; waiting for it\n";
      reported_ = true;
      return false;
    }
    gps_stream(&data_, WATCH_ENABLE | WATCH_JSON, nullptr);
    reported_ = false;
    return open_ = true;
  }
  void close() {
    if (!open_) return;
    gps_stream(&data_, WATCH_DISABLE, nullptr);
    gps_close(&data_);
    open_ = false;
  }

  const std::string host_, port_;
  gps_data_t data_{};
  bool open_ = false;
  bool reported_ = false;  ///< that there is no connection
};

void run(const Options& options) {
  const SocketAddress to = address_of(options.to), any = address_of("0.0.0.0:0");
  RealClock clock;
  UdpLink link(clock);
  host::require(link.open(any, &to), "--to " + options.to);
  Receiver receiver(options);
  std::uint16_t count = 0;
  UtcNs latest = 0;
  while (ended == 0) {
    NavigationSample sample;
    UtcNs utc = 0;
    if (!receiver.next(sample, utc) || utc <= latest) continue;
    latest = utc;
    std::vector<std::uint8_t> packet(max_navigation_packet_bytes);
    std::size_t bytes = 0;
    if (!encode_navigation_packet(sample, utc, options.apid, count++, packet, bytes).ok()) continue;
    static_cast<void>(link.send(std::span(packet).first(bytes)));  // the flight software may start later
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    Options options;
    host::CommandLine app("ilp-gps", "Sends the positions of gpsd to ilp-onboard --navigation-udp, until it is ended",
                          "ilp-gps --to 127.0.0.1:9000");
    app.add_option("--gpsd", options.host, "host of gpsd");
    app.add_option("--port", options.port, "port of gpsd");
    app.add_option("--to", options.to, "ADDRESS:PORT of the flight software")->required();
    app.add_option("--apid", options.apid, "APID of the packets (navigation.vehicle_apid)");
    app.set_version_flag("--version", ilp::host::version_line("ilp-gps"));
    if (const auto end = ilp::host::read_command_line(app, argc, argv)) return *end;
    std::signal(SIGTERM, [](int) { ended = 1; });
    std::signal(SIGINT, [](int) { ended = 1; });
    run(options);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ilp-gps: " << error.what() << "\n";
    return 1;
  }
}
