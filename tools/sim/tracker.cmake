# The simulated laser tracker.
find_package(Boost 1.81 REQUIRED)
add_library(truepose_sim_tracker STATIC emscon_server.cpp tracker_settings.cpp)
target_link_libraries(truepose_sim_tracker PUBLIC truepose_proto Boost::headers Threads::Threads)
