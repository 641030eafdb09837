// Only here: the example client in Python, which knows of us what protocol/README.md says and nothing else.
#include <cstdlib>

#include "tests/system/real_pace_rig.hpp"

namespace armsight::demo {
namespace {

TEST_F(RealPace, ObeysTheExampleClientInPython) {
  const std::string modules = (folder_ / "python").string();
  std::filesystem::create_directories(modules);
  const std::string protoc = "protoc -I '" ARMSIGHT_HOME "' --python_out='" + modules + "' protocol/arm_link.proto";
  ASSERT_EQ(std::system(protoc.c_str()), 0) << protoc;
  go_to_start();
  ASSERT_EQ(arm().host({"status"}), 0);
  const std::string before = line_of("joints:");

  std::vector<std::string> lines;
  const int code = conductor().run("client",
                                   {"/usr/bin/env", "PYTHONPATH=" + modules, "/usr/bin/python3",
                                    ARMSIGHT_HOME "/protocol/examples/arm_client.py", arm().link(), "0.4"},
                                   &lines);
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(code, 0) << lines.back();
  EXPECT_TRUE(lines.back().starts_with("stopped after +0.")) << lines.back();
  EXPECT_EQ(lines.back().find("+0.400"), std::string::npos) << "it was stopped under way: " << lines.back();
  EXPECT_EQ(arm().host({"status"}), 0);
  EXPECT_NE(line_of("joints:"), before) << "it moved";
  EXPECT_NE(line_of("mode:").find("hold"), std::string::npos) << line_of("mode:");
}

}  // namespace
}  // namespace armsight::demo
