"""Names that look unused to vulture and are not: called by others, or by name, or by tests."""

# motorid/__init__.py: Python calls them: the public face is imported when it is asked for
_.__getattr__
_.__dir__

# motorid/acquire/journal.py: read a journal's bytes: tests of what a crash leaves
_.parse_journal

# motorid/acquire/port.py: pyserial's own attribute
_.timeout

# motorid/cli/lazy.py: click calls or reads them
_.list_commands
_.get_command
_.short_help
_.format_commands

# motorid/cli/sim.py: click calls or reads them
_.pty

# motorid/cli/streams.py: click calls or reads them
_.writable
_.__stdout__
_.__stderr__

# motorid/cli/values.py: click calls or reads them
_._describe_range

# motorid/errors.py: the documented table of exit codes, to which tests hold every command
_.MEANING_OF_EXIT

# motorid/estimate/diagnosis/faults/scale_errors.py: bench and tests call it
_.by_disc

# motorid/estimate/diagnosis/identifiability.py: part of what is known of a run; tests read it
_.null_directions

# motorid/quality/capability.py: a field of a result that people read
_.sigma_overall

# motorid/quality/guard_band.py: the risks of docs/quality.md, by quadrature; tests call it
_.risks

# motorid/quality/history/database.py: SQLAlchemy calls or reads them
_.connected
_.isolation_level

# motorid/quality/history/schema.py: SQLAlchemy calls or reads them
_.impl
_.cache_ok
_.process_bind_param
_.process_result_value

# motorid/quality/reference.py: a published estimate beside which the usual one is tested
_.sigma_by_range

# motorid/quality/stations.py: a field of a result that scripts read
_.limits_95

# motorid/sim/bench.py: fields of structs that compiled code reads
_.supply_zero
_.voltage_zero
_.signs_left
_.signs_from
_.sign_current
_.sign_voltage
_.sign_counts
_.armed
_.supply_max
_.supply_min
_.frozen
_.cubic
_.reaction_current
_.eddy_share
_.eddy_resistance
_.coupling_torque
_.short_depth
_.stribeck_speed
_.commutation
_.commutation_speed
_.k_ripple
_.r_ripple
_.copper_coefficient
_.magnet_coefficient
_.housing_resistance
_.winding_resistance
_.winding_capacity
_.housing_capacity
_.pwm_period
_.diode_resistance
_.sense_at_bridge
_.switch_drop
_.switch_drop_current
_.supply_voltage

# motorid/sim/board.py: requests of the protocol, called by name
_._do_identify
_._do_describe_channel
_._do_configure
_._do_read_config
_._do_clear_program
_._do_add_step
_._do_start
_._do_stop
_._do_heartbeat
_._do_zero
_._do_read_status
_._do_clear_fault
_._do_describe_input
_._do_read_front_end
_._do_write_front_end

# motorid/wire/enums.py: members of the protocol's enumerations
_.BOOT
_.FRONT_END
_.Sensor
_.SHUNT
_.HALL
_.MAGNITUDE
_.MOSFET
_.BIPOLAR
_.IN_IN
_.PWM_DIR
_.FrontEndSource
_.COMPILED
_.STORED

# motorid/wire/spec.py: fields of the protocol's description, from its file
_.reply_deadline_ms
_.boot_deadline_ms
_.attempts

# motorid/workflow/orders.py: attributes that the standard library's server reads
_.daemon_threads
_.address_family

# motorid/limits.py: the table of docs/file-format.md, which a test compares
_.markdown

# motorid/search/review/ideal.py: what the review's weights waste; a bench and a test ask
_.searches

# motorid/web/server.py: uvicorn reads it
_.should_exit

# motorid/look.py: notebooks and scripts call them
_._repr_html_
_.to_dataframe
_.plot

# motorid/rig_model.py: written into each capture by its key, where the fit reads it
_.rated_current_a

# motorid/acquire/scpi/link.py: a resource of pyvisa reads them
_.read_termination
_.write_termination

# motorid/workflow/conformance/bundle.py: zipfile reads them
_.compress_type
_.external_attr

# motorid/quality/history/migrations: Alembic reads or calls them
_.down_revision
_.revision
_.upgrade

# motorid/workflow/tls_link.py: io.BufferedReader calls it
_.readinto

# motorid/workflow/mqtt/witness.py: paho's client reads or calls them
_.connect_timeout
_.on_connect
_.on_connect_fail
_.on_disconnect
_.on_message
_.on_publish

# motorid/workflow/opcua: asyncua calls or reads them
_.get_user
_.check_validity
_.Serial
_.Outcome
_.Key
_.Reasons
_.Severity
# motorid/program.py: a rig file names it
_.BRAKED
# motorid/quality/history/tallies.py: SQLAlchemy reads or calls them
_.inherit_cache
_._as_text
_._as_date
_._in_partitions

# motorid/web/metrics.py: prometheus_client calls it
_.collect
