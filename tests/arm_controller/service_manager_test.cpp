// What the service manager hears: a socket of ours in its place.
#include "arm_controller/service_manager.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

namespace armsight::arm {
namespace {

class ServiceManagerTest : public testing::Test {
 protected:
  void SetUp() override {
    listener_ = Descriptor(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::snprintf(address.sun_path, sizeof address.sun_path, "%s", path_.c_str());
    ASSERT_EQ(::bind(listener_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::setenv("NOTIFY_SOCKET", path_.c_str(), 1);
    ::setenv("WATCHDOG_USEC", "400000", 1);
    ::setenv("WATCHDOG_PID", std::to_string(::getpid()).c_str(), 1);
  }
  void TearDown() override {
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) ::unsetenv(name);
    std::filesystem::remove(path_);
  }
  std::string heard() {
    char text[256];
    const ssize_t size = ::recv(listener_.get(), text, sizeof text, 0);
    return size < 0 ? "" : std::string(text, static_cast<std::size_t>(size));
  }

  std::string path_ = testing::TempDir() + "armsight-notify-" + std::to_string(::getpid());
  Descriptor listener_;
  Time start_ = time_from_ns(1'000'000'000);
};

TEST_F(ServiceManagerTest, HearsReadyAndStopping) {
  ServiceManager manager;
  manager.say_ready("500 Hz on can0");
  EXPECT_EQ(heard(), "READY=1\nSTATUS=500 Hz on can0");
  manager.say_stopping();
  EXPECT_EQ(heard(), "STOPPING=1");
}

TEST_F(ServiceManagerTest, IsKickedFourTimesInTheWatchdogsTimeWhileTheCycleGoesOn) {
  ServiceManager manager;
  int kicks = 0;
  for (std::uint64_t cycle = 1; cycle <= 1000; ++cycle) {  // 2 s at 500 Hz
    manager.say_alive(start_ + std::chrono::milliseconds(2 * static_cast<long>(cycle)), cycle);
    if (heard() == "WATCHDOG=1") ++kicks;
  }
  EXPECT_GE(kicks, 19);
  EXPECT_LE(kicks, 20);
}

TEST_F(ServiceManagerTest, IsNotKickedByACycleThatStands) {
  ServiceManager manager;
  manager.say_alive(start_, 7);
  EXPECT_EQ(heard(), "WATCHDOG=1");
  for (int i = 1; i < 100; ++i) manager.say_alive(start_ + std::chrono::milliseconds(50 * i), 7);
  EXPECT_EQ(heard(), "");
}

TEST_F(ServiceManagerTest, IsNotKickedForAnotherProcess) {
  ::setenv("WATCHDOG_PID", "1", 1);
  ServiceManager manager;
  manager.say_alive(start_, 7);
  EXPECT_EQ(heard(), "");
}

TEST_F(ServiceManagerTest, IsLeftAloneWhereThereIsNone) {
  for (const char* name : {"", "relative/path", "/"}) {
    ::setenv("NOTIFY_SOCKET", name, 1);
    ServiceManager manager;
    manager.say_ready("");
    EXPECT_EQ(heard(), "");
  }
}

}  // namespace
}  // namespace armsight::arm
