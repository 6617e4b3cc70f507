// Who gives way to a new connection, and how long a request may take, with a server of three places.
#include "sim/ground/serve/connection_places.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <string>
#include <vector>

#include "hal/posix/socket_address.hpp"

namespace ilp::serve {
namespace {

using namespace std::chrono_literals;

/// Answers /trust at once and as one who has shown the token, and / at once. /wait is answered when the connection
/// gives way.
class SmallServer {
 public:
  explicit SmallServer(std::chrono::milliseconds request)
      : places_(3, request, [this] {
          const std::lock_guard lock(mutex_);
          gone_.notify_all();
        }) {
    address_.host = 0x7F000001;
    int socket = -1;
    EXPECT_TRUE(open_socket(SocketKind::tcp, address_, socket).ok());
    EXPECT_TRUE(local_address(socket, address_).ok());
    daemon_ =
        MHD_start_daemon(MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_THREAD_PER_CONNECTION | MHD_USE_POLL, 0, nullptr,
                         nullptr, &on_request, this, MHD_OPTION_LISTEN_SOCKET, socket, MHD_OPTION_CONNECTION_LIMIT,
                         places_.library_limit(), MHD_OPTION_NOTIFY_CONNECTION, &ConnectionPlaces::on_connection,
                         &places_, MHD_OPTION_NOTIFY_COMPLETED, &on_end, this, MHD_OPTION_END);
    EXPECT_NE(daemon_, nullptr);
  }
  ~SmallServer() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    gone_.notify_all();
    MHD_stop_daemon(daemon_);
  }
  SmallServer(const SmallServer&) = delete;
  SmallServer& operator=(const SmallServer&) = delete;
  [[nodiscard]] SocketAddress address() const { return address_; }
  /// Until so many requests for /wait have come.
  void await(int requests) {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(gone_.wait_for(lock, 60s, [&] { return waiting_ == requests; }));
  }

 private:
  static MHD_Result on_request(void* self, MHD_Connection* connection, const char* path, const char*, const char*,
                               const char*, std::size_t*, void** context) {
    auto& server = *static_cast<SmallServer*>(self);
    if (*context == nullptr) {
      *context = self;
      return MHD_YES;
    }
    ConnectionPlaces::Connection& place = ConnectionPlaces::of(connection);
    if (std::string(path) == "/trust") server.places_.trust(place);
    server.places_.answer(place);
    if (std::string(path) == "/wait") {
      std::unique_lock lock(server.mutex_);
      ++server.waiting_;
      server.gone_.notify_all();
      server.gone_.wait(lock, [&] { return place.gone || server.ending_; });
    }
    MHD_Response* response = MHD_create_response_from_buffer(2, const_cast<char*>("ok"), MHD_RESPMEM_PERSISTENT);
    const MHD_Result queued = MHD_queue_response(connection, MHD_HTTP_OK, response);
    MHD_destroy_response(response);
    return queued;
  }
  static void on_end(void* self, MHD_Connection* connection, void** context, MHD_RequestTerminationCode) {
    static_cast<SmallServer*>(self)->places_.end_request(ConnectionPlaces::of(connection));
    *context = nullptr;
  }

  std::mutex mutex_;
  std::condition_variable gone_;
  bool ending_ = false;
  int waiting_ = 0;
  ConnectionPlaces places_;
  SocketAddress address_;
  MHD_Daemon* daemon_ = nullptr;
};

class Client {
 public:
  explicit Client(const SmallServer& server, const std::string& text = "") {
    socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
    const sockaddr_in address = system_address(server.address());
    EXPECT_EQ(::connect(socket_, general(&address), sizeof(address)), 0);
    say(text);
  }
  ~Client() { close_socket(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  bool say(const std::string& text) {
    return ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  void ask(const std::string& path) { say("GET " + path + " HTTP/1.1\r\nHost: x\r\n\r\n"); }
  /// Whether a whole answer comes; false at the end of the connection.
  bool answered() {
    std::string text;
    while (text.find("\r\n\r\nok") == std::string::npos) {
      char part[512];
      const ssize_t got = ::recv(socket_, part, sizeof(part), 0);
      if (got <= 0) return false;
      text.append(part, static_cast<std::size_t>(got));
    }
    return true;
  }
  /// Whether the server ends the connection within this time.
  [[nodiscard]] bool ends(std::chrono::milliseconds within) const {
    pollfd waiting{socket_, POLLIN, 0};
    char part = 0;
    return ::poll(&waiting, 1, static_cast<int>(within.count())) == 1 && ::recv(socket_, &part, 1, MSG_PEEK) <= 0;
  }

 private:
  int socket_ = -1;
};

constexpr std::chrono::milliseconds patience = 60s, soon = 100ms;

TEST(ConnectionPlaces, TheOldestOfThoseThatAskGivesWay) {
  const SmallServer server(patience);
  Client first(server, "GET / HT"), second(server), third(server, "G");
  Client fourth(server);
  EXPECT_TRUE(first.ends(patience));
  EXPECT_FALSE(second.ends(soon));
  fourth.ask("/");
  EXPECT_TRUE(fourth.answered());
  // An answer gives no place for ever: the next two take those that were there before.
  Client fifth(server), sixth(server);
  EXPECT_TRUE(second.ends(patience));
  EXPECT_TRUE(third.ends(patience));
  EXPECT_FALSE(fourth.ends(soon));
}

TEST(ConnectionPlaces, WhoIsAnsweredStaysLongerAndWhoHasTheTokenLongest) {
  SmallServer server(patience);
  Client trusted(server);
  trusted.ask("/trust");
  ASSERT_TRUE(trusted.answered());
  Client waits(server);
  waits.ask("/wait");
  server.await(1);
  for (int i = 0; i < 50; ++i) {
    Client passes(server, "GET / ");
    Client next(server);
    EXPECT_TRUE(passes.ends(patience)) << i;
  }
  EXPECT_FALSE(waits.ends(soon)) << "it gives way to nobody who has asked for nothing";
  Client also(server);
  also.ask("/wait");
  server.await(2);
  const Client new_one(server);
  EXPECT_TRUE(waits.ends(patience)) << "the oldest of those that are answered";
  EXPECT_FALSE(trusted.ends(soon));
  trusted.ask("/trust");
  EXPECT_TRUE(trusted.answered());
}

TEST(ConnectionPlaces, ThatAllHaveShownTheTokenAreSharedToo) {
  const SmallServer server(patience);
  Client first(server), second(server), third(server);
  for (Client* client : {&first, &second, &third}) {
    client->ask("/trust");
    ASSERT_TRUE(client->answered());
  }
  Client fourth(server);
  fourth.ask("/trust");
  EXPECT_TRUE(fourth.answered());
  EXPECT_TRUE(first.ends(patience));
}

TEST(ConnectionPlaces, ARequestHasADeadlineHoweverOftenAnOctetComes) {
  SmallServer server(2s);
  Client answered(server);
  answered.ask("/wait");
  server.await(1);
  Client slow(server, "GET / HTTP/1.1\r\nX: ");
  bool open = true;
  while (open) {
    open = slow.say("x") && !slow.ends(50ms);
  }
  EXPECT_FALSE(answered.ends(soon)) << "what is answered takes the time that it takes";
  // The next request on a connection has the same time.
  Client again(server);
  again.ask("/");
  ASSERT_TRUE(again.answered());
  EXPECT_TRUE(again.ends(patience));
}

}  // namespace
}  // namespace ilp::serve
