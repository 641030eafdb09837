// The controller's Debian package: what is in it, that what it installs starts and holds an arm, that an upgrade keeps
// what the owner changed and the arm has learnt.
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <iterator>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {
namespace {

namespace fs = std::filesystem;

struct Output {
  int code = -1;
  std::string text;
};

Output shell(const std::string& command) {
  Output output;
  FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return output;
  char line[512];
  while (std::fgets(line, sizeof line, pipe) != nullptr) output.text += line;
  const int status = ::pclose(pipe);
  output.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return output;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Package : public SystemTest {
 protected:
  void SetUp() override {
    fs::create_directories(work_);
    const fs::path tree = quiet_robot().programs.parent_path();
    const Output packed = shell("cd '" + work_.string() + "' && cpack -G DEB --config '" +
                                (tree / "CPackConfig.cmake").string() + "' -B '" + work_.string() + "'");
    ASSERT_EQ(packed.code, 0) << packed.text;
    for (const auto& entry : fs::directory_iterator(work_))
      if (entry.path().extension() == ".deb") package_ = entry.path();
    ASSERT_FALSE(package_.empty()) << packed.text;
  }

  void TearDown() override {
    SystemTest::TearDown();
    fs::remove_all(work_);
  }

  std::string field(const std::string& name) {
    std::string text = shell("dpkg-deb -f '" + package_.string() + "' " + name).text;
    return text.substr(0, text.find('\n'));
  }

  /// dpkg on a folder as if it were the root of a machine; as an ordinary user in a namespace of its own.
  Output install(const fs::path& package, const fs::path& root) {
    const std::string as_root = ::getuid() == 0 ? "" : "unshare -r ";
    return shell(as_root + "dpkg --root='" + root.string() +
                 "' --force-script-chrootless --force-depends --log=/dev/null -i '" + package.string() +
                 "' < /dev/null");
  }

  fs::path work_ = folder_.string() + "-package", package_;
};

TEST_F(Package, HoldsTheProgramItsFileItsUnitAndItsPage) {
  EXPECT_EQ(field("Package"), "armsight-controller");
  EXPECT_EQ(field("Architecture"), shell("dpkg --print-architecture").text.substr(0, 5));
  EXPECT_NE(field("Depends").find("libc6 (>="), std::string::npos) << field("Depends");
  EXPECT_EQ(field("Depends").find("opencv"), std::string::npos) << field("Depends");
  const std::string content = shell("dpkg-deb -c '" + package_.string() + "'").text;
  for (const char* file :
       {"./usr/bin/arm_controller", "./etc/armsight/arm.yaml", "./usr/share/man/man8/arm_controller.8",
        "./lib/systemd/system/armsight-controller@.service", "./lib/udev/rules.d/60-armsight-controller.rules",
        "./usr/lib/sysusers.d/armsight-controller.conf", "./usr/share/armsight-controller/network/80-can0.network"})
    EXPECT_NE(content.find(file), std::string::npos) << file << " is not in\n" << content;
  EXPECT_EQ(shell("dpkg-deb -I '" + package_.string() + "' conffiles").text, "/etc/armsight/arm.yaml\n");
}

TEST_F(Package, InstalledStartsAndHoldsAnArm) {
  const fs::path stage = work_ / "stage", programs = work_ / "programs";
  ASSERT_EQ(shell("dpkg-deb -x '" + package_.string() + "' '" + stage.string() + "'").code, 0);
  fs::create_directories(programs);
  DemoOptions options = quiet_robot();
  for (const char* name : {"arm_sim", "host"}) fs::create_symlink(options.programs / name, programs / name);
  fs::create_symlink(stage / "usr/bin/arm_controller", programs / "arm_controller");
  options.programs = programs;
  options.robot_file = stage / "etc/armsight/arm.yaml";
  start(options);
  EXPECT_EQ(arm().host({"move", "--joints=0.4,0.1,-0.2,1.2,-0.5"}), 0);
  ASSERT_EQ(arm().host({"status"}), 0);
  const auto is_hold = [](const std::string& line) {
    return line.starts_with("mode:") && line.find("hold") != line.npos;
  };
  EXPECT_TRUE(std::ranges::any_of(arm().host_lines(), is_hold));
}

TEST_F(Package, UpgradeKeepsTheOwnersFileAndTheModel) {
  const fs::path root = work_ / "root", unpacked = work_ / "next", next = work_ / "next.deb";
  fs::create_directories(root / "var/lib/dpkg/info");
  fs::create_directories(root / "var/lib/dpkg/updates");
  for (const char* name : {"status", "available"}) std::ofstream(root / "var/lib/dpkg" / name);
  const Output first = install(package_, root);
  ASSERT_EQ(first.code, 0) << first.text;
  const fs::path robot = root / "etc/armsight/arm.yaml", model = root / "var/lib/armsight-can0/model.yaml";
  std::ofstream(robot, std::ios::app) << "# the owner's line\n";
  fs::create_directories(model.parent_path());
  std::ofstream(model) << "learnt\n";

  ASSERT_EQ(shell("dpkg-deb -R '" + package_.string() + "' '" + unpacked.string() +
                  "' && sed -i 's/^Version: .*/Version: 99/' '" + (unpacked / "DEBIAN/control").string() +
                  "' && dpkg-deb --root-owner-group -b '" + unpacked.string() + "' '" + next.string() + "'")
                .code,
            0);
  const Output second = install(next, root);
  ASSERT_EQ(second.code, 0) << second.text;
  EXPECT_NE(text_of(root / "var/lib/dpkg/status").find("Version: 99"), std::string::npos);
  EXPECT_NE(text_of(robot).find("# the owner's line"), std::string::npos);
  EXPECT_EQ(text_of(model), "learnt\n");
}

}  // namespace
}  // namespace armsight::demo
