#![no_main]

use inhand_session::Settings;

libfuzzer_sys::fuzz_target!(init: inhand_fuzz::start(), |bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let settings = match serde_json::from_str(text) {
        Ok(value) => Settings::from_json(&value).ok(),
        Err(_) => toml::from_str::<Settings>(text).ok(),
    };
    let Some(settings) = settings else { return };
    let _ = (settings.read_settings(), settings.import_settings());
    if let Ok(written) = settings.to_toml() {
        let again: Settings = toml::from_str(&written).expect("own output");
        assert_eq!(settings.to_json(), again.to_json(), "read again");
    }
});
