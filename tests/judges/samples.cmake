# Makes the samples for the judges.
file(REMOVE_RECURSE ${SAMPLES})
execute_process(COMMAND ${MAKE_SAMPLES} ${SAMPLES} RESULT_VARIABLE made)
if(NOT made EQUAL 0)
  message(FATAL_ERROR "the samples could not be made")
endif()
