#include "sim/ground/serve/serve_main.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "sim/ground/console/link_options.hpp"
#include "sim/ground/flight_options.hpp"
#include "sim/ground/serve/http_reply.hpp"
#include "sim/ground/serve/page_server.hpp"
#include "sim/host/command_line.hpp"
#include "sim/host/files.hpp"

namespace ilp::serve {
namespace {
namespace fs = std::filesystem;

struct Options {
  ground::GroundOptions ground;
  console::LinkOptions link;
  std::string flight, listen = "127.0.0.1:8080", token_file;
  bool open_commands = false;
  int every_s = 1;
};

SocketAddress listening_address(const std::string& text) {
  SocketAddress address;
  if (!parse_address(text.c_str(), address).ok()) {
    throw std::runtime_error("an address to listen at is written 127.0.0.1:8080, not " + text);
  }
  return address;
}

// None unless the user asks for it.
std::unique_ptr<Commands> commands_of(const Options& options, const SocketAddress& listen) {
  if (options.link.address.empty()) {
    if (!options.token_file.empty() || options.open_commands) {
      throw std::runtime_error(
          "--token-file and --commands-from-other-computers are for commands: say where the flight listens, with "
          "--commands 127.0.0.1:10025, or leave them out");
    }
    return nullptr;
  }
  if (!is_loopback(listen) && !options.open_commands) {
    throw std::runtime_error("other computers could give commands at " + options.listen +
                             ": name 127.0.0.1, and reach it with ssh -L, or add --commands-from-other-computers");
  }
  return std::make_unique<Commands>(read_token(options.token_file), console::operator_settings(options.link));
}

// The folder of a flight holds its downlink as `outbox`, as the simulator writes it.
void find_folders(Options& options) {
  const fs::path given = fs::absolute(options.flight).lexically_normal();
  fs::path folder = given.has_filename() ? given : given.parent_path();
  if (!fs::is_directory(folder)) {
    throw std::runtime_error(options.flight +
                             " is no folder: name the folder in which the files arrive (create it before the "
                             "flight), or the folder of a flight");
  }
  if (fs::is_directory(folder / "outbox")) folder /= "outbox";
  options.ground.outbox = folder;
  if (!options.ground.out.empty()) return;
  const bool outbox = folder.filename() == "outbox";
  options.ground.out = folder.parent_path() / (outbox ? "ground" : folder.filename().string() + "-ground");
}

// Held until the process ends. The runs of two servers in one folder would be mixed.
void lock_folder(const fs::path& folder) {
  host::make_output_folder(folder);
  const fs::path path = folder / "serve.lock";
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0) throw std::runtime_error("cannot write " + path.string() + ": " + host::write_failure(errno));
  if (::flock(file, LOCK_EX | LOCK_NB) != 0) {
    throw std::runtime_error("another ilp-ground serve works in " + folder.string() +
                             ": open its page, end it, or name another folder with --out");
  }
}

int serve(Options& options) {
  find_folders(options);
  ground::require_apart(options.ground);
  lock_folder(options.ground.out);
  LiveFlight flight(options.ground);
  const SocketAddress listen = listening_address(options.listen);
  const std::unique_ptr<Commands> commands = commands_of(options, listen);
  // The page loads its panel of commands by this.
  if (commands) flight.state().put("commands", true);
  const PageServer server(listen, flight, commands.get());
  std::cout << "The flight is at http://" << server.address() << "\nResults: " << options.ground.out.string() << "\n";
  if (commands) std::cout << "Commands go to the flight at " << options.link.address << "\n";
  std::cout << std::flush;
  while (true) {
    flight.look(std::cerr);
    std::this_thread::sleep_for(std::chrono::seconds(options.every_s));
  }
}

}  // namespace

int serve_main(int argc, char** argv) {
  host::CommandLine app(
      "ilp-ground serve",
      "Shows a live flight in a browser: map, track, products, telemetry, events and plots grow as files arrive. The "
      "page only shows the flight; with --commands it has a panel that operates it (docs/serve.md)",
      "ilp-ground serve flight --listen 127.0.0.1:8080", "Exit status: 1 the work could not be done, 2 wrong call");
  Options options;
  app.add_option(
         "flight", options.flight,
         "folder into which the flight's files are received, or the folder of a flight, which contains `outbox`")
      ->required();
  app.add_option("--out", options.ground.out,
                 "folder for the results (default: `ground` beside an outbox, else the folder's name with -ground)");
  app.add_option("--listen", options.listen,
                 "ADDRESS:PORT of the page; with another address, everybody who reaches it can "
                 "read the flight; port 0: any free one");
  app.add_option("--every", options.every_s, "seconds between two searches for new files")->check(CLI::Range(1, 3600));
  ground::add_flight_options(app, options.ground);
  app.add_option(
      "--commands", options.link.address,
      "ADDRESS:PORT at which the flight listens for commands: the page then has a panel for them, which asks "
      "for a token (default: no panel)");
  app.add_option("--token-file", options.token_file,
                 "file with the token that the panel of commands asks for (default: the variable ILP_COMMAND_TOKEN)");
  app.add_flag("--commands-from-other-computers", options.open_commands,
               "lets --listen name an address that other computers reach; nothing is encrypted there");
  options.link.source = 2;
  options.ground.more_comes = true;
  console::add_link_options(app, options.link);
  if (const auto end = ilp::host::read_command_line(app, argc, argv)) return *end;
  (void)std::signal(SIGPIPE, SIG_IGN);
  try {
    return serve(options);
  } catch (const host::WrongUsage& error) {
    std::cerr << "ilp-ground serve: " << error.what() << "\n";
    return host::wrong_usage;
  } catch (const std::exception& error) {
    std::cerr << "ilp-ground serve: " << error.what() << "\n";
    return 1;
  }
}

}  // namespace ilp::serve
