// Framed streams at real pace: what arrives, what ends a stream, what a stranger cannot do.
#include "protocol/transport/framed_stream.hpp"

#include <gtest/gtest.h>

#include <sys/socket.h>

#include "tools/temporary_folder.hpp"

namespace armsight::net {
namespace {

using namespace std::chrono_literals;

const StreamOptions kOptions{wire::FrameType::kLink, wire::kMaxFromController, wire::kMaxFromController, 1024 * 1024};

std::vector<Received> receive_some(FramedStream& stream) {
  for (int i = 0; i < 100 && stream.is_open(); ++i) {
    auto messages = stream.receive();
    if (!messages.empty()) return messages;
    const int descriptors[] = {stream.descriptor()};
    wait_readable(descriptors, 100ms);
  }
  return {};
}

std::vector<StreamServer::Event> serve_some(StreamServer& server) {
  for (int i = 0; i < 100; ++i) {
    auto events = server.receive();
    if (!events.empty()) return events;
    wait_readable(server.descriptors(), 100ms);
  }
  return {};
}

struct Transport : ::testing::Test {
  std::unique_ptr<Clock> clock = make_monotonic_clock(1ms);
  StreamServer server{"127.0.0.1:0", ChannelKind::kLink, kOptions, *clock, [](std::string_view) { return 0u; }, 2};
  std::string address = "127.0.0.1:" + std::to_string(server.port());
  std::unique_ptr<FramedStream> connect() { return connect_tcp(address, kOptions, *clock, 5s); }
};

TEST_F(Transport, CarriesMessagesBothWays) {
  auto client = connect();
  ASSERT_TRUE(client->send("hello"));
  const auto events = serve_some(server);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].message.payload, "hello");
  ASSERT_TRUE(events[0].stream->send("welcome"));
  const auto answer = receive_some(*client);
  ASSERT_EQ(answer.size(), 1u);
  EXPECT_EQ(answer[0].payload, "welcome");
}

TEST_F(Transport, ReportsAClosedPeerAfterItsLastMessage) {
  auto client = connect();
  client->send("last words");
  client.reset();
  const auto first = serve_some(server);
  ASSERT_GE(first.size(), 1u);
  EXPECT_EQ(first[0].message.payload, "last words");
  const auto events =
      first.size() > 1 ? std::vector<StreamServer::Event>(first.begin() + 1, first.end()) : serve_some(server);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_TRUE(events[0].is_closed);
  EXPECT_EQ(events[0].stream->close_reason(), "closed by the peer");
}

TEST_F(Transport, ClosesOnABrokenFrameAndSaysWhy) {
  auto client = connect();
  client->send("hello");
  serve_some(server);
  const char garbage[] = "GET / HTTP/1.1\r\n\r\n";
  ASSERT_GT(::send(client->descriptor(), garbage, sizeof garbage, MSG_NOSIGNAL), 0);
  const auto events = serve_some(server);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_TRUE(events[0].is_closed);
  EXPECT_NE(events[0].stream->close_reason().find("bad frame"), std::string::npos);
}

TEST_F(Transport, RefusesMoreStreamsThanItHasRoomFor) {
  auto first = connect();
  auto second = connect();
  auto third = connect();
  first->send("1");
  second->send("2");
  serve_some(server);
  for (int i = 0; i < 50 && third->is_open(); ++i) {
    server.receive();
    third->receive();
    const int descriptors[] = {third->descriptor()};
    wait_readable(descriptors, 20ms);
  }
  EXPECT_FALSE(third->is_open());
  EXPECT_TRUE(first->is_open());
}

TEST_F(Transport, ClosesAStreamWhosePeerDoesNotRead) {
  StreamOptions narrow = kOptions;
  narrow.max_queued_bytes = 64 * 1024;
  auto client = connect_tcp(address, narrow, *clock, 5s);
  const std::string block(32 * 1024, 'x');
  int sent = 0;
  while (client->send(block) && sent < 10'000) ++sent;
  EXPECT_FALSE(client->is_open());
  EXPECT_EQ(client->close_reason(), "peer reads too slowly");
}

TEST_F(Transport, NamesAnAddressThatNobodyServes) {
  auto listener = listen_tcp("127.0.0.1:0");
  const std::string dead = "127.0.0.1:" + std::to_string(listener->port());
  listener.reset();
  try {
    connect_tcp(dead, kOptions, *clock, 1s);
    FAIL() << "connected";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()), "cannot reach " + dead + ": Connection refused");
  }
  EXPECT_THROW(connect_tcp("127.0.0.1", kOptions, *clock, 1s), std::runtime_error);
  EXPECT_THROW(connect_tcp("127.0.0.1:99999", kOptions, *clock, 1s), std::runtime_error);
}

TEST(Listener, TakesOverAStaleSocketFileButNoOtherFile) {
  TemporaryFolder folder;
  const std::string path = folder.file("clock");
  listen_unix(path).reset();
  EXPECT_NO_THROW(listen_unix(path));
  FILE* file = std::fopen(folder.file("text").c_str(), "w");
  std::fclose(file);
  EXPECT_THROW(listen_unix(folder.file("text")), std::runtime_error);
  EXPECT_TRUE(std::filesystem::exists(folder.file("text")));
}

TEST(MonotonicClock, SkipsAndCountsTheCyclesOfALateCaller) {
  const auto clock = make_monotonic_clock(1ms);
  clock->wait_next_cycle();
  const Time late = clock->now() + 20ms;
  while (clock->now() < late) {
  }
  const Time next = clock->wait_next_cycle();
  EXPECT_GE(clock->missed(), 15u);
  EXPECT_GE(next, late);
}

}  // namespace
}  // namespace armsight::net
